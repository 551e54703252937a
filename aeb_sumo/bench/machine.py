"""What a measurement was made on."""

import platform
from os import cpu_count, getloadavg, sched_getaffinity
from pathlib import Path

import aeb_sumo

__all__ = ["load", "machine"]


def load() -> float:
    """Processes that ran or waited for a core, on average over the last minute."""
    return getloadavg()[0]


def machine(sumo: str, busy: float) -> dict[str, str | int | float]:
    """The processor, how many cores of it this process may use, and the versions of what ran there.

    Args:
        sumo: version of SUMO.
        busy: the load before anything was measured.
    """
    return {
        "cpu": _processor(),
        "cores": cpu_count() or 1,
        "cores_usable": len(sched_getaffinity(0)),
        "load_before": round(busy, 2),
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        "sumo": sumo.removeprefix("SUMO "),
        "aeb_sumo": aeb_sumo.__version__,
    }


def _processor() -> str:
    """Its name; that of the architecture where Linux does not say it."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        text = ""
    names = [line.partition(":")[2].strip() for line in text.splitlines() if line.startswith("model name")]
    return names[0] if names else platform.machine()
