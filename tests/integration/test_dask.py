"""A campaign on a Dask cluster: a real scheduler and two workers, processes of their own on the loopback."""

import hashlib
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from aeb_sumo.results import TABLES, finished
from tests.helpers import command, runs_at_work, wait_for

pytest.importorskip("distributed")

SPEC = """[factors]
scenario = "{scenario}"
strategy = ["none", "staged"]
seed = "1..4"
[run]
duration_s = {duration}
"""


def tables(folder: Path) -> dict[str, str]:
    files = (path for name in TABLES for path in (folder / name).glob("*.parquet"))
    return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def dask(kind: str, *options: str, folder: Path) -> "subprocess.Popen[bytes]":
    words = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *options]
    with (folder / f"{kind}.log").open("ab") as log:
        return subprocess.Popen(words, stdout=log, stderr=log, cwd=folder)


@pytest.fixture
def cluster(tmp_path):
    """Address of a scheduler, its process, and those of its two workers."""
    folder = tmp_path / "dask"
    folder.mkdir()
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    local = ("--host", "127.0.0.1", "--no-dashboard")
    processes = [dask("scheduler", *local, "--port", str(port), folder=folder)]
    for number in range(2):
        place = folder / str(number)
        place.mkdir()
        processes.append(dask("worker", address, *local, "--nthreads", "1", "--no-nanny", folder=place))
    wait_for(lambda: all(b"Registered to" in (folder / str(k) / "worker.log").read_bytes() for k in range(2)))
    yield address, processes[0], processes[1:]
    for process in reversed(processes):
        process.kill()
        process.wait()


def start(spec: Path, out: Path, address: str) -> "subprocess.Popen[str]":
    """A campaign that names its files as seen from their folder, where no worker stands."""
    words = [sys.executable, "-m", "aeb_sumo", "campaign", spec.name, "--out", out.name, "--scheduler", address]
    return subprocess.Popen(words, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=spec.parent)


@pytest.mark.slow
def test_a_worker_that_dies_half_way_changes_nothing(cluster, tmp_path):
    address, _, workers = cluster
    spec = tmp_path / "spec.toml"
    spec.write_text(SPEC.format(scenario="w0", duration=60))
    here = command("campaign", spec, "--out", tmp_path / "here", "--quiet")
    assert here.returncode == 0, here.stderr
    campaign = start(spec, tmp_path / "there", address)
    wait_for(lambda: len(finished(tmp_path / "there")) >= 2)
    (orphan,) = wait_for(lambda: runs_at_work(workers[0].pid))
    workers[0].kill()
    out, errors = campaign.communicate(timeout=120)
    assert campaign.returncode == 0, errors
    assert "8 runs: 8 completed, 0 failed" in out
    assert not Path(f"/proc/{orphan}").exists()
    assert tables(tmp_path / "there") == tables(tmp_path / "here")


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGKILL])
def test_a_campaign_that_ends_leaves_no_run_on_the_cluster(cluster, tmp_path, end):
    address, _, workers = cluster
    spec = tmp_path / "spec.toml"
    spec.write_text(SPEC.format(scenario="w0", duration=3600))
    campaign = start(spec, tmp_path / "out", address)
    wait_for(lambda: all(runs_at_work(worker.pid) for worker in workers))
    campaign.send_signal(end)
    campaign.communicate(timeout=30)
    assert campaign.returncode == (130 if end == signal.SIGINT else -signal.SIGKILL)
    wait_for(lambda: not any(runs_at_work(worker.pid) for worker in workers), 20)
    assert not finished(tmp_path / "out")
    assert not tables(tmp_path / "out")


@pytest.mark.slow
def test_a_scheduler_that_dies_is_one_line_and_loses_nothing(cluster, tmp_path):
    address, scheduler, _ = cluster
    spec = tmp_path / "spec.toml"
    spec.write_text(SPEC.format(scenario="track", duration=8))
    campaign = start(spec, tmp_path / "out", address)
    kept = wait_for(lambda: finished(tmp_path / "out"))
    scheduler.kill()
    _, errors = campaign.communicate(timeout=60)
    assert campaign.returncode == 2
    (line,) = errors.splitlines()
    assert "the executor of the runs is gone; finished runs are kept" in line
    assert kept <= finished(tmp_path / "out")
    done = command("campaign", spec, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "8 runs: 8 completed, 0 failed" in done.stdout


WRONG = [
    "tcp://127.0.0.1:9", "tcp://no.such.host.invalid:8786", "nonsense", "tcp://127.0.0.1", "tcp://127.0.0.1:x",
    "nonsense://127.0.0.1:9", "inproc://x", "tls://127.0.0.1:9", "ucx://127.0.0.1:9",
]  # fmt: skip


@pytest.mark.parametrize("address", WRONG)
def test_a_scheduler_that_cannot_be_reached_is_one_line_and_touches_nothing(tmp_path, address):
    refused(tmp_path, address)


def test_what_does_not_speak_like_a_scheduler_is_none(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as silent:
        refused(tmp_path, f"tcp://127.0.0.1:{silent.getsockname()[1]}")


def test_a_worker_is_no_scheduler(cluster, tmp_path):
    (address,) = re.findall(r"Start worker at: +(\S+)", (tmp_path / "dask/0/worker.log").read_text())
    assert "it is a worker" in refused(tmp_path, address)


def refused(folder: Path, address: str) -> str:
    """The one line that a campaign says of a scheduler; in a process of its own, whose threads may have more to say."""
    (folder / "spec.toml").write_text(SPEC.format(scenario="track", duration=8))
    patience = "from aeb_sumo.campaign import cluster; cluster._PATIENCE = 1.0; from aeb_sumo.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", patience, "campaign", "spec.toml", "--out", "new", "--scheduler", address],
        check=False, capture_output=True, text=True, cwd=folder, timeout=15,
    )  # fmt: skip
    assert done.returncode == 2, done.stderr
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"aeb-sumo: --scheduler {address} cannot be reached: ")
    assert line.endswith("; allowed: tcp://HOST:PORT of a Dask scheduler")
    assert not (folder / "new").exists()
    return line


def test_a_cluster_has_its_own_number_of_workers(tmp_path):
    (tmp_path / "spec.toml").write_text(SPEC.format(scenario="track", duration=8))
    done = command("campaign", "spec.toml", "--out", "new", "--scheduler", "tcp://x:1", "--workers", 2, cwd=tmp_path)
    assert done.returncode == 2
    assert "--workers are those of this machine" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["spec.toml"]
