"""Starting, stepping and stopping SUMO."""

import os
import re
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import ClassVar, Self

import libsumo

from aeb_sumo.errors import InputError

__all__ = ["IMPOSED", "Session", "SumoError", "output_prefix"]

IMPOSED: tuple[str, ...] = (
    # Speeds commanded under Euler integration stop v dt / 2 short.
    "--step-method.ballistic", "true",
    # Crashes are found and counted here: SUMO shall report every contact, also in junctions, and do nothing else.
    "--collision.action", "warn",
    "--collision.check-junctions", "true",
    "--collision.mingap-factor", "0",
    # A run must be repeatable, and silent on the terminal.
    "--random", "false",
    "--no-step-log", "true",
    "--duration-log.disable", "true",
    # A GUI's settings are of no use here, and a missing file of them stops SUMO.
    "--gui-settings-file", "",
    # A port in the configuration would make SUMO wait for a client.
    "--remote-port", "0",
)  # fmt: skip
"""SUMO options that every run sets, over those of a user's own configuration."""


_REFUSALS = (libsumo.TraCIException, libsumo.FatalTraCIError)


class SumoError(InputError):
    """SUMO refused its input or gave up; the message carries SUMO's own reason."""


_TO_ROOT = "../" * 60  # from any folder: above the root is the root


def output_prefix(folder: str, own: str = "") -> str:
    """Value of `--output-prefix` that sends every output file of SUMO into `folder` (absolute).

    SUMO puts the prefix before the last part of each output's path, so enough `../` lead to the root from wherever the
    configuration or an additional file would have written, and from there to `folder`. Two outputs of the same name in
    different folders become one.

    Raises:
        InputError: the folder's path has "TIME" in it, which SUMO would replace by the time of day.
    """
    if "TIME" in folder:
        raise InputError(f"{folder}: SUMO cannot write into a folder with TIME in its path; name another")
    return _TO_ROOT + folder.strip("/") + "/" + Path(own).name


class Session:
    """The one simulation that libsumo can run in a process; use it as a context manager.

    Attributes:
        dt: step length [s].
        begin: simulated time at the start [s].
    """

    _running: ClassVar[bool] = False

    def __init__(self, options: Sequence[str]) -> None:
        """Start SUMO with `options` (without the program's name).

        Raises:
            SumoError: SUMO refuses them.
            RuntimeError: this process runs a simulation already; libsumo would silently drop it.
        """
        if Session._running:
            raise RuntimeError("libsumo runs one simulation per process, and one is running")
        self._messages = tempfile.TemporaryFile(mode="w+b")  # noqa: SIM115 - closed with the session
        self._streams = os.dup(1), os.dup(2)
        try:
            with self._silenced():
                libsumo.start(["sumo", *options])
            self.dt: float = libsumo.simulation.getDeltaT()
            self.begin: float = libsumo.simulation.getTime()
        except _REFUSALS as error:
            reason = self._reason(error)
            self._end()
            raise SumoError(reason) from None
        Session._running = True

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the simulation; SUMO writes its outputs."""
        if not Session._running:
            return
        Session._running = False
        with self._silenced():
            libsumo.close()
        self._end()

    def _end(self) -> None:
        self._messages.close()
        for stream in self._streams:
            os.close(stream)

    def step(self) -> None:
        """Simulate one step.

        Raises:
            SumoError: SUMO gave up, for instance on a broken route.
        """
        # As `_silenced`, for less: nothing is printed from Python meanwhile.
        target = self._messages.fileno()
        os.dup2(target, 1)
        os.dup2(target, 2)
        try:
            libsumo.simulationStep()
        except _REFUSALS as error:
            raise SumoError(self._reason(error)) from None
        finally:
            os.dup2(self._streams[0], 1)
            os.dup2(self._streams[1], 2)

    @property
    def time(self) -> float:
        """Simulated time [s], that of the last step's end."""
        # Rounded to SUMO's own clock of milliseconds: 0.1 added up is not.
        return round(float(libsumo.simulation.getTime()), 3)

    @property
    def seed(self) -> int:
        """SUMO's random seed."""
        return int(libsumo.simulation.getOption("seed"))

    @property
    def end(self) -> float | None:
        """Simulated time at which the scenario ends by its own options [s]; None for no such time."""
        end = float(libsumo.simulation.getEndTime())
        return end if end > self.begin else None

    @property
    def time_to_teleport(self) -> float:
        """How long a vehicle stands before SUMO puts it elsewhere [s]; `inf` for never."""
        seconds = float(libsumo.simulation.getOption("time-to-teleport"))
        return seconds if seconds > 0 else float("inf")

    @property
    def sublane(self) -> bool:
        """Whether vehicles can be beside their lane's centre."""
        return (
            float(libsumo.simulation.getOption("lateral-resolution")) > 0
            or float(libsumo.simulation.getOption("lanechange.duration")) > 0
        )

    @property
    def vehicle_types(self) -> frozenset[str]:
        """Ids of the vehicle types known so far; SUMO reads routes, and the types among them, a while ahead."""
        return frozenset(libsumo.vehicletype.getIDList())

    @property
    def exhausted(self) -> bool:
        """No vehicle is or will be in the network."""
        return bool(libsumo.simulation.getMinExpectedNumber() == 0)

    @property
    def version(self) -> str:
        """SUMO's version."""
        return str(libsumo.getVersion()[1])

    @contextmanager
    def _silenced(self) -> Iterator[None]:
        """What SUMO prints goes into a file: it would tear the progress bar, and holds the reason of an error."""
        sys.stdout.flush()
        sys.stderr.flush()
        target = self._messages.fileno()
        saved = [os.dup(stream) for stream in (1, 2)]
        try:
            for stream in (1, 2):
                os.dup2(target, stream)
            yield
        finally:
            for stream, copy in zip((1, 2), saved, strict=True):
                os.dup2(copy, stream)
                os.close(copy)

    def _reason(self, error: Exception) -> str:
        """SUMO's own reason in one line; the exception alone often says no more than "Process Error"."""
        self._messages.seek(0)
        lines = self._messages.read().decode(errors="replace").splitlines()
        errors = [line.removeprefix("Error: ").strip() for line in lines if line.startswith("Error")]
        # After an "Error:" line, SUMO continues its reason in indented lines.
        for index, line in enumerate(lines[:-1]):
            if line.startswith("Error") and lines[index + 1].startswith(" "):
                errors.append(lines[index + 1].strip())
        text = "; ".join(dict.fromkeys(e for e in errors if e and not e.startswith("Quitting")))
        # Name an output file as the configuration does, without the detour of `output_prefix`.
        return "SUMO: " + re.sub(f"{re.escape(_TO_ROOT)}.*/", "", " ".join((text or str(error)).split()))
