"""aeb-sumo campaign: many runs in fresh processes, ended and resumed; nothing is lost, nothing is doubled."""

import hashlib
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import analysis
from aeb_sumo.campaign.execute import Outcome, execute
from aeb_sumo.campaign.expansion import expand
from aeb_sumo.campaign.failure import row_of
from aeb_sumo.campaign.lock import locked
from aeb_sumo.campaign.runner import execute_all, payload
from aeb_sumo.campaign.spec import read
from aeb_sumo.campaign.workers import dismiss_idle
from aeb_sumo.errors import InputError
from aeb_sumo.results import TABLES, commit_failure, finished
from aeb_sumo.results.command import arguments
from tests.helpers import SMALL_CAMPAIGN, campaign_workers, command, runs_at_work, wait_for


def tables(folder: Path) -> dict[str, str]:
    """Every file of every table -> digest of its content."""
    files = (path for name in TABLES for path in (folder / name).glob("*"))
    return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def start(spec: Path, out: Path, *options: str, **popen: object) -> "subprocess.Popen[str]":
    words = [sys.executable, "-m", "aeb_sumo", "campaign", str(spec), "--out", str(out), *options]
    return subprocess.Popen(words, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **popen)


def finish(process: "subprocess.Popen[str]") -> tuple[int, str, str]:
    out, err = process.communicate(timeout=120)
    return process.returncode, out, err


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    path = tmp_path / "spec.toml"
    path.write_text(SMALL_CAMPAIGN.format(seeds=[1, 2, 3]))
    return path


@pytest.fixture(scope="module")
def reference(tmp_path_factory) -> Path:
    """The tables of a campaign that nothing has disturbed."""
    folder = tmp_path_factory.mktemp("reference")
    (folder / "spec.toml").write_text(SMALL_CAMPAIGN.format(seeds=[1, 2, 3]))
    done = command("campaign", folder / "spec.toml", "--out", folder / "out", "--workers", 2)
    assert done.returncode == 0, done.stderr
    assert "6 runs: 6 completed, 0 failed" in done.stdout
    return folder / "out"


def test_a_campaign_is_loaded_as_one_and_its_runs_can_be_repeated(reference, tmp_path):
    data = analysis.load(reference)
    assert len(data.runs) == 6
    assert set(data.runs["outcome"]) == {"completed"}
    assert analysis.effect(data)["seeds"].unique().tolist() == [3]
    row = data.runs.loc[data.runs["strategy"] == "staged"].iloc[0]
    again = command(*arguments(row), "--out", tmp_path / "again", "--quiet")
    assert again.returncode == 0, again.stderr
    crashes = analysis.load(tmp_path / "again").crashes.drop(columns="run_id")
    own = data.crashes[data.crashes["run_id"] == row["run_id"]].drop(columns="run_id")
    pd.testing.assert_frame_equal(crashes, own.reset_index(drop=True))


def test_what_is_there_is_not_executed_again(reference, tmp_path, spec):
    out = shutil.copytree(reference, tmp_path / "out")
    (removed,) = out.glob("runs/*none*s2*")
    removed.unlink()
    before = {path: path.stat().st_mtime_ns for path in (out / "runs").iterdir()}
    listed = command("campaign", spec, "--out", out, "--dry-run")
    assert listed.returncode == 0
    assert [line.split()[0] for line in listed.stdout.splitlines()[:-1]] == [removed.stem]
    assert "strategy=none seed=2 duration_s=8.0" in listed.stdout
    assert listed.stdout.splitlines()[-1] == "6 runs: 5 are there, 1 would be executed"
    assert not removed.exists()
    done = command("campaign", spec, "--out", out)
    assert done.returncode == 0
    assert "6 runs: 6 completed, 0 failed, 5 were there before" in done.stdout
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert tables(out) == tables(reference)


def test_a_dry_run_makes_nothing(tmp_path, spec):
    done = command("campaign", spec, "--out", tmp_path / "new", "--dry-run")
    assert done.returncode == 0
    assert done.stdout.splitlines()[-1] == "6 runs: 0 are there, 6 would be executed"
    assert not (tmp_path / "new").exists()


def test_seeds_can_be_added(reference, tmp_path, spec):
    out = tmp_path / "out"
    for seeds in ([1], [3, 1], "1..3"):
        spec.write_text(SMALL_CAMPAIGN.format(seeds=repr(seeds)))
        done = command("campaign", spec, "--out", out, "--quiet")
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert tables(out) == tables(reference)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda spec, _: spec.write_text(SMALL_CAMPAIGN.format(seeds=[1, 2])), "the nearest differs in seed (3 there"),
        (
            lambda spec, _: spec.write_text(SMALL_CAMPAIGN.format(seeds=[1, 2, 3]).replace("= 8", "= 9")),
            "the nearest differs in duration_s (8.0 there, 9.0 here)",
        ),
        (lambda _, out: (out / "campaign.json").unlink(), "holds results that are of no campaign"),
        (lambda _, out: (out / "campaign.json").write_text("{"), "campaign.json cannot be read: it is damaged"),
        (lambda _, out: (out / "campaign.json").write_text('{"format": 9, "runs": {}}'), "another version"),
    ],
)
@pytest.mark.parametrize("option", [(), ("--dry-run",)])
def test_a_folder_of_something_else_is_refused(reference, tmp_path, spec, change, reason, option):
    out = shutil.copytree(reference, tmp_path / "out")
    change(spec, out)
    before = {path: path.stat().st_mtime_ns for path in out.rglob("*")}
    done = command("campaign", spec, "--out", out, *option)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert reason in line
    assert {path: path.stat().st_mtime_ns for path in out.rglob("*")} == before


@pytest.mark.parametrize("option", [(), ("--dry-run",)])
def test_a_folder_that_is_a_file_or_lies_in_one_is_one_line(tmp_path, spec, option):
    (tmp_path / "file").write_text("precious")
    for out in (tmp_path / "file", tmp_path / "file" / "in"):
        done = command("campaign", spec, "--out", out, *option)
        assert done.returncode == 2
        (line,) = done.stderr.splitlines()
        assert line == f"aeb-sumo: cannot read {out}/campaign.json: Not a directory"
    assert (tmp_path / "file").read_text() == "precious"


def test_two_campaigns_cannot_work_in_one_folder(tmp_path, spec):
    out = tmp_path / "out"
    out.mkdir()
    with locked(str(out)):
        done = command("campaign", spec, "--out", out)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert f"another campaign works in {out} (process {os.getpid()})" in line
    assert sorted(path.name for path in out.iterdir()) == [".lock"]


def test_a_lock_dies_with_its_process(tmp_path):
    code = (
        "import sys, time\nfrom aeb_sumo.campaign.lock import locked\n"
        "with locked(sys.argv[1]):\n    print('held', flush=True)\n    time.sleep(100)"
    )
    holder = subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    assert holder.stdout is not None
    assert holder.stdout.readline() == "held\n"
    with pytest.raises(InputError, match="another campaign works in"), locked(str(tmp_path)):
        pass
    holder.kill()
    holder.communicate()
    with locked(str(tmp_path)):
        pass


MANY = SMALL_CAMPAIGN.replace("= 8", "= 20").format(seeds="'1..12'")
"""Of 24 runs, which take a few seconds in all."""


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> Path:
    """The tables of a longer campaign."""
    folder = tmp_path_factory.mktemp("undisturbed")
    (folder / "spec.toml").write_text(MANY)
    done = command("campaign", folder / "spec.toml", "--out", folder / "out", "--workers", 2)
    assert done.returncode == 0, done.stderr
    return folder / "out"


def kill_and_resume(spec: Path, out: Path, chance: np.random.Generator, kills: int) -> None:
    """SIGKILL a campaign at random moments, then let it end."""
    spec.write_text(MANY)
    for _ in range(kills):
        process = start(spec, out, "--workers", "2")
        wanted = min(len(finished(out)) + int(chance.integers(8)), 23)
        wait_for(lambda n=wanted, p=process: len(finished(out)) >= n or p.poll() is not None)
        time.sleep(chance.uniform(0.0, 0.3))
        process.kill()
        process.communicate()
    code, _, errors = finish(start(spec, out, "--workers", "2"))
    assert code == 0, errors


def test_a_campaign_that_is_killed_and_started_again_is_as_if_it_never_was(undisturbed, tmp_path, spec):
    kill_and_resume(spec, tmp_path / "out", np.random.default_rng(1), kills=2)
    assert tables(tmp_path / "out") == tables(undisturbed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_the_same_at_many_random_moments(undisturbed, tmp_path, spec, seed):
    kill_and_resume(spec, tmp_path / "out", np.random.default_rng(100 + seed), kills=3)
    assert tables(tmp_path / "out") == tables(undisturbed)


LONG = SMALL_CAMPAIGN.replace('"track"', '"w0"').replace("= 8", "= 3600").format(seeds=[1, 2])


def test_workers_of_a_campaign_that_is_killed_end_and_leave_nothing(tmp_path, spec):
    spec.write_text(LONG)
    out = tmp_path / "out"
    process = start(spec, out, "--workers", "2")
    at_work = wait_for(lambda: len(found := runs_at_work(process.pid)) == 2 and list(out.glob("runs/.*")) and found)
    process.kill()
    process.communicate()
    wait_for(lambda: not any(Path(f"/proc/{pid}").exists() for pid in at_work), 20)
    assert not tables(out)


def test_ctrl_c_ends_the_workers_and_keeps_what_is_finished(undisturbed, tmp_path, spec):
    spec.write_text(MANY)
    out = tmp_path / "out"
    process = start(spec, out, "--workers", "2")
    wait_for(lambda: finished(out))
    at_work = campaign_workers(process.pid) + runs_at_work(process.pid)
    process.send_signal(signal.SIGINT)
    code, _, errors = finish(process)
    assert code == 130
    (line,) = errors.splitlines()
    assert "interrupted; finished runs are kept, and the same command does the rest" in line
    assert not any(Path(f"/proc/{pid}").exists() for pid in at_work)
    assert 0 < len(finished(out)) < 24
    assert set(analysis.load(out).runs["outcome"]) == {"completed"}
    assert command("campaign", spec, "--out", out).returncode == 0
    assert tables(out) == tables(undisturbed)


def test_a_run_whose_process_dies_is_a_row_and_the_campaign_goes_on(reference, tmp_path, spec):
    out = tmp_path / "out"
    process = start(spec, out, "--workers", "1")
    (victim,) = wait_for(lambda: runs_at_work(process.pid))
    os.kill(victim, signal.SIGKILL)
    code, summary, errors = finish(process)
    assert code == 1
    assert "6 runs: 5 completed, 1 failed" in summary
    (line,) = errors.splitlines()
    assert line.startswith("aeb-sumo: failed: track-")
    assert "its process was ended by SIGKILL (Killed)" in line
    data = analysis.load(out)
    assert len(data.runs) == 5
    (row,) = data.died.to_dict("records")
    assert "SIGKILL" in row["reason"]
    assert (row["scenario"], row["step_length_s"]) == ("track", 0.1)
    assert command("compare", out).returncode == 0

    again = command("campaign", spec, "--out", out)
    assert again.returncode == 1, "what failed stays failed"
    assert "failed (before; --retry-failed executes it again)" in again.stderr
    listed = command("campaign", spec, "--out", out, "--dry-run").stdout
    assert "6 runs: 6 are there, of which 1 failed (--retry-failed executes these again), 0 would be" in listed
    listed = command("campaign", spec, "--out", out, "--dry-run", "--retry-failed").stdout
    assert listed.startswith(row["run_id"])
    assert "6 runs: 5 are there, 1 would be executed" in listed
    retried = command("campaign", spec, "--out", out, "--retry-failed")
    assert retried.returncode == 0, retried.stderr
    assert tables(out) == tables(reference)


@pytest.mark.parametrize(("number", "name"), [(signal.SIGABRT, "SIGABRT (Aborted)"), (40, "signal 40 (Real-time")])
def test_a_process_that_is_ended_by_any_signal_is_a_row_that_says_so(tmp_path, spec, number, name):
    job = payload(expand(read(spec))[0], str(tmp_path / "out"))
    with ThreadPoolExecutor(1) as executor:
        future = executor.submit(execute, job)
        (run,) = wait_for(lambda: runs_at_work(os.getpid()))
        os.kill(run, number)
        outcome = future.result(60)
    assert outcome.outcome == "failed"
    assert outcome.reason.startswith(f"its process was ended by {name}")


def test_a_worker_that_is_killed_is_a_row_that_says_so_and_another_takes_its_place(tmp_path, spec):
    jobs = [payload(job, str(tmp_path / "out")) for job in expand(read(spec))]
    with ThreadPoolExecutor(1) as executor:
        future = executor.submit(execute, jobs[0])
        wait_for(lambda: runs_at_work(os.getpid()))
        (worker,) = campaign_workers(os.getpid())
        os.kill(worker, signal.SIGKILL)
        assert future.result(60).reason.startswith("its process was ended by SIGKILL (Killed)")
    assert execute(jobs[1]).outcome == "completed"
    dismiss_idle()


def test_a_run_whose_worker_is_killed_does_not_go_on_by_itself(tmp_path, spec):
    spec.write_text(LONG)
    out = tmp_path / "out"
    out.mkdir()
    with locked(str(out)), ThreadPoolExecutor(1) as executor:
        future = executor.submit(execute, payload(expand(read(spec))[0], str(out)))
        (run,) = wait_for(lambda: runs_at_work(os.getpid()))
        (worker,) = campaign_workers(os.getpid())
        os.kill(run, signal.SIGSTOP)  # does not hear that its worker has died
        os.kill(worker, signal.SIGKILL)
        assert "SIGKILL" in future.result(60).reason
    with locked(str(out)):
        assert not tables(out)


def test_a_worker_that_talks_much_is_listened_to(tmp_path, spec, monkeypatch):
    monkeypatch.setenv("PYTHONVERBOSE", "1")
    assert execute(payload(expand(read(spec))[0], str(tmp_path / "out"))).outcome == "completed"
    dismiss_idle()


def test_what_cannot_be_learnt_from_a_run_does_not_touch_its_result(tmp_path, spec, monkeypatch):
    (tmp_path / "sitecustomize.py").write_text(
        f"import pickle\ndef dump(*_):\n    open({str(tmp_path / 'asked')!r}, 'w').close()\n"
        "    raise pickle.PicklingError('odd')\npickle.dump = dump\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    outcome = execute(payload(expand(read(spec))[0], str(tmp_path / "out")))
    assert (outcome.outcome, outcome.in_tables) == ("completed", True)
    assert outcome.cpu_s > 0
    assert (tmp_path / "asked").exists()
    dismiss_idle()


def test_all_of_the_program_that_a_run_imports_is_there_before_its_code_is_looked_at(tmp_path):
    code = """import sys
from aeb_sumo.campaign.run import get_ready
get_ready()
before = set(sys.modules)
from aeb_sumo import scenarios
from aeb_sumo.simulate import run
run(scenarios.load("w0"), "zhao2025", duration=5, verdicts="all", out=sys.argv[1])
print(sorted(name for name in set(sys.modules) - before if name.startswith("aeb_sumo")))
"""
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, check=False)
    assert done.stdout.splitlines()[-1:] == ["[]"], done.stderr


def test_workers_do_one_run_after_the_other_for_one_campaign_and_may_leave_in_between(tmp_path, spec):
    first, second, third, fourth = expand(read(spec))[:4]
    out = str(tmp_path / "out")
    assert execute(payload(first, out, "one")).outcome == "completed"
    (worker,) = campaign_workers(os.getpid())
    assert execute(payload(second, out, "one")).outcome == "completed"
    assert campaign_workers(os.getpid()) == [worker]
    assert execute(payload(third, out, "two")).outcome == "completed"
    (other,) = set(campaign_workers(os.getpid())) - {worker}  # code and files may have changed since
    os.kill(other, signal.SIGTERM)
    assert execute(payload(fourth, out, "two")).outcome == "completed"
    assert len(set(campaign_workers(os.getpid())) - {worker, other}) == 1
    dismiss_idle()
    assert not campaign_workers(os.getpid())


def test_a_run_that_takes_too_long_is_killed(tmp_path, spec):
    spec.write_text(LONG + "limit_s = 3\n")
    job = expand(read(spec))[0]
    began = time.monotonic()
    outcome = execute(payload(job, str(tmp_path / "out")))
    assert 3 <= time.monotonic() - began < 30
    assert (outcome.outcome, outcome.in_tables) == ("failed", False)
    assert outcome.reason == "took longer than limit_s, 3 s, and was killed"
    assert not tables(tmp_path / "out")


def test_a_run_that_sumo_refuses_is_a_row_with_the_reason(tmp_path, spec):
    (tmp_path / "bad.rou.xml").write_text(
        '<routes><vehicle id="v" depart="0"><route edges="nowhere"/></vehicle></routes>'
    )
    shutil.copy(Path(expand.__code__.co_filename).parents[2] / "sumo_nets/track/track.net.xml", tmp_path / "net.xml")
    (tmp_path / "bad.sumocfg").write_text(
        '<configuration><net-file value="net.xml"/><route-files value="bad.rou.xml"/><end value="5"/></configuration>'
    )
    spec.write_text('[factors]\nscenario = ["bad.sumocfg", "track"]\nstrategy = "none"\n[run]\nduration_s = 5\n')
    done = command("campaign", spec, "--out", tmp_path / "out")
    assert done.returncode == 1
    assert "2 runs: 1 completed, 1 failed" in done.stdout
    data = analysis.load(tmp_path / "out")
    assert data.runs["scenario"].tolist() == ["track"]
    (row,) = data.died.to_dict("records")
    assert row["scenario"] == "bad.sumocfg"
    assert "nowhere" in row["reason"]


def test_a_run_is_not_simulated_where_it_would_be_another_one(tmp_path, spec):
    job = payload(expand(read(spec))[0], str(tmp_path / "out"))
    job["content"]["code"] = {"source": "another", "sumo": "0.1"}
    outcome = execute(job)
    assert outcome.outcome == "mismatch"
    assert outcome.reason.startswith('code ({"source": "another"')
    assert not (tmp_path / "out").exists()


def test_a_full_disk_is_one_line_and_loses_nothing(reference, tmp_path, spec):
    out = shutil.copytree(reference, tmp_path / "out")
    for path in out.glob("*/*s3*"):
        path.unlink()
    kept = tables(out)
    # No file may be larger than a table of runs: like a full disk, but for this process alone.
    largest = max(path.stat().st_size for path in out.glob("*/*.parquet"))
    full = start(
        spec,
        out,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (largest - 1000, resource.RLIM_INFINITY)),
    )
    code, _, errors = finish(full)
    assert code == 2
    (line,) = errors.splitlines()
    assert f"cannot write into {out}: File too large; finished runs are kept: make room" in line
    assert kept.items() <= tables(out).items()
    assert set(analysis.load(out).runs["outcome"]) == {"completed"}
    assert command("campaign", spec, "--out", out).returncode == 0
    assert tables(out) == tables(reference)


@pytest.mark.slow
def test_a_disk_that_is_really_full(reference, tmp_path, spec):
    small = tmp_path / "small"
    small.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=200k", "tmpfs", str(small)], check=False, capture_output=True
    )
    if mounted.returncode:
        pytest.skip("only root can make a small disk")
    try:
        full = command("campaign", spec, "--out", small / "out")
        assert full.returncode == 2
        (line,) = full.stderr.splitlines()
        assert "No space left on device" in line
        kept = tables(small / "out")
        assert kept.items() <= tables(reference).items()
        subprocess.run(["mount", "-o", "remount,size=9m", str(small)], check=True)
        assert command("campaign", spec, "--out", small / "out").returncode == 0
        assert tables(small / "out") == tables(reference)
    finally:
        subprocess.run(["umount", str(small)], check=True)


@pytest.mark.slow
def test_a_process_that_hangs_and_does_not_listen_is_killed(tmp_path, spec):
    spec.write_text(LONG + "limit_s = 5\n")
    job = payload(expand(read(spec))[0], str(tmp_path / "out"))
    with ThreadPoolExecutor(1) as executor:
        future = executor.submit(execute, job)
        (run,) = wait_for(lambda: runs_at_work(os.getpid()))
        os.kill(run, signal.SIGSTOP)
        outcome = future.result(60)
    assert (outcome.outcome, outcome.reason) == ("failed", "took longer than limit_s, 5 s, and was killed")
    assert not Path(f"/proc/{run}").exists()


def test_any_executor_will_do(reference, tmp_path, spec):
    out = str(tmp_path / "out")
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        outcomes = execute_all(expand(read(spec)), out, executor)
    assert {each.outcome for each in outcomes} == {"completed"}
    assert tables(tmp_path / "out") == tables(reference)


class Lossy(ThreadPoolExecutor):
    """Loses the second job that it is given."""

    count = 0

    def submit(self, fn, /, *arguments, **named):
        self.count += 1
        return super().submit(lose if self.count == 2 else fn, *arguments, **named)


def lose(*_: object) -> None:
    raise ConnectionError("the machine is gone")


def test_a_job_that_its_executor_loses_is_a_row(tmp_path, spec):
    spec.write_text(SMALL_CAMPAIGN.format(seeds=[1]))
    out = str(tmp_path / "out")
    with Lossy(2) as executor:
        outcomes = {each.run_id: each for each in execute_all(expand(read(spec)), out, executor)}
    data = analysis.load(out)
    assert data.runs["strategy"].tolist() == ["none"]
    (row,) = data.died.to_dict("records")
    assert (row["strategy"], row["reason"]) == ("staged", "ConnectionError: the machine is gone")
    assert outcomes[row["run_id"]].outcome == "failed"


def test_tables_go_to_any_file_system(reference, tmp_path, spec):
    spec.write_text(SMALL_CAMPAIGN.format(seeds=[1]))
    out = f"simplecache::file://{tmp_path}/bucket"
    for there in ("", ", 2 were there before"):
        done = command("campaign", spec, "--out", out)
        assert done.returncode == 0, done.stderr
        assert f"2 runs: 2 completed, 0 failed{there}." in done.stdout
        assert "is locked against a second campaign on this machine alone" in done.stderr
    assert tables(tmp_path / "bucket").items() <= tables(reference).items()
    spec.write_text(SMALL_CAMPAIGN.format(seeds=[2]))
    refused = command("campaign", spec, "--out", out)
    assert refused.returncode == 2
    assert "belongs to another campaign" in refused.stderr
    unknown = command("campaign", spec, "--out", "nowhere://bucket")
    assert unknown.returncode == 2
    assert "nowhere" in unknown.stderr
    assert len(unknown.stderr.splitlines()) == 1


def test_a_process_that_dies_when_all_is_written_has_lost_nothing(reference, tmp_path, spec):
    spec.write_text(SMALL_CAMPAIGN.format(seeds=[1]))
    with DeadAtTheEnd(2) as executor:
        outcomes = execute_all(expand(read(spec)), str(tmp_path / "out"), executor)
    assert {each.outcome for each in outcomes} == {"completed"}
    assert tables(tmp_path / "out").items() <= tables(reference).items()


def test_a_process_that_dies_when_its_failure_is_written_has_failed(tmp_path, spec):
    spec.write_text(SMALL_CAMPAIGN.format(seeds=[1]))
    (job, _) = expand(read(spec))
    out = str(tmp_path / "out")

    def fail_and_die(told: dict[str, object]) -> Outcome:
        commit_failure(out, row_of(job.run_id, job.settings, "SUMO has had enough"))
        return Outcome(run_id=str(told["run_id"]), outcome="failed", reason="its process was ended by SIGKILL (Killed)")

    with ThreadPoolExecutor(1) as executor:
        (outcome,) = execute_all([job], out, executor, how=fail_and_die)
    assert (outcome.outcome, outcome.reason) == ("failed", "SUMO has had enough")


def test_results_that_nobody_else_can_see_are_not_taken_for_done(tmp_path, spec):
    spec.write_text(SMALL_CAMPAIGN.format(seeds=[1]))
    done = command("campaign", spec, "--out", "memory://study")
    assert done.returncode == 2
    assert done.stdout == ""
    reason = done.stderr.splitlines()[-1]
    assert "was written where it was executed, but is not in memory://study here" in reason
    assert reason.endswith("name a folder or URL that all processes and machines share")


class DeadAtTheEnd(ThreadPoolExecutor):
    """Its workers cannot say any more that they are done."""

    def submit(self, fn, /, *arguments, **named):
        return super().submit(silent, fn, *arguments, **named)


def silent(fn, *arguments: object) -> Outcome:
    done = fn(*arguments)
    return Outcome(run_id=done.run_id, outcome="failed", reason="its process was ended by SIGKILL (Killed)")
