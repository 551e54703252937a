"""Makes inputs for tests, and runs the command."""

import resource
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout, suppress
from io import StringIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np

from aeb_sumo.cli import main
from aeb_sumo.strategies.base import Percept

SMALL_CAMPAIGN = """[factors]
scenario = "track"
strategy = ["none", "staged"]
seed = {seeds}
[run]
duration_s = 8
"""
"""To be given seeds."""


def vehicle(name: str, position: float, speed: float, kind: str = "car", inside: str = "") -> str:
    """A vehicle on the track in SUMO's XML, there at once and on the right lane."""
    where = f'route="r" depart="0" departLane="0" departPos="{position}" departSpeed="{speed}" insertionChecks="none"'
    return f'<vehicle id="{name}" type="{kind}" {where}>{inside}</vehicle>'


def approach(ego_kmh: float, lead_kmh: float, gap: float) -> str:
    """An ego 600 m down the track behind a lead of 4.6 m, bumper to bumper `gap` apart."""
    return vehicle("lead", 604.6 + gap, lead_kmh / 3.6) + vehicle("ego", 600, ego_kmh / 3.6)


def percept(**values: object) -> Percept:
    """A percept of one row per value; a lead straight ahead on a dry road unless told otherwise."""
    defaults = {"gap": 50.0, "ego_speed": 20.0, "ego_accel": 0.0, "target_speed": 0.0, "target_accel": 0.0, "mu": 0.85}
    defaults |= {"left": 0.0, "closing_left": 0.0}
    n = max(np.size(v) for v in values.values()) if values else 1
    rows = {k: np.broadcast_to(np.asarray(values.get(k, d), float), n).copy() for k, d in defaults.items()}
    rows["ahead"] = np.broadcast_to(np.asarray(values.get("ahead", rows["gap"]), float), n).copy()
    closing = values.get("closing_ahead", rows["ego_speed"] - rows["target_speed"])
    rows["closing_ahead"] = np.broadcast_to(np.asarray(closing, float), n).copy()
    masks = {
        k: np.broadcast_to(np.asarray(values.get(k, d)), n).copy() for k, d in (("valid", True), ("vulnerable", False))
    }
    return Percept(**masks, **rows)


def command(*arguments: object, cwd: Path | None = None) -> SimpleNamespace:
    """`aeb-sumo` with some arguments, in this process: what it prints, and its exit status."""
    out, err, status = StringIO(), StringIO(), 0
    with (
        chdir(cwd or Path.cwd()),
        redirect_stdout(out),
        redirect_stderr(err),
        patch.object(sys, "argv", ["aeb-sumo", *map(str, arguments)]),
    ):
        try:
            main()
        except SystemExit as end:
            status = int(end.code or 0)
    return SimpleNamespace(returncode=status, stdout=out.getvalue(), stderr=err.getvalue())


@contextmanager
def full_disk(size: int) -> Iterator[None]:
    """For this process no file can be larger than so many bytes: like a full disk."""
    _, hard = before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def campaign_workers(pid: int) -> list[int]:
    """The workers of a campaign that is executed in a process."""
    return [child for child in _children(pid) if b"aeb_sumo.campaign.worker" in _command_line(child)]


def runs_at_work(pid: int) -> list[int]:
    """The processes of runs that its workers have forked."""
    return [run for worker in campaign_workers(pid) for run in _children(worker)]


def _children(pid: int) -> list[int]:
    found: list[int] = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        with suppress(OSError):  # it has ended meanwhile
            found += map(int, task.read_text().split())
    return found


def _command_line(pid: int) -> bytes:
    with suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    return b""


def wait_for(what: Callable[[], Any], seconds: float = 60.0) -> Any:
    """What `what` gives as soon as that is true."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if found := what():
            return found
        time.sleep(0.01)
    raise AssertionError("it did not happen")
