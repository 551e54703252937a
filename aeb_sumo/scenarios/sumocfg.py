"""A user's own SUMO scenario, run as it is."""

from pathlib import Path

from aeb_sumo.drivers.profile import Profile
from aeb_sumo.scenarios.base import Scenario
from aeb_sumo.world.sumocfg import read

__all__ = ["from_sumocfg"]

_STEP_LENGTH = 0.1  # s, where the configuration does not say


def from_sumocfg(path: str | Path, drivers: Profile | None = None) -> Scenario:
    """The scenario of a .sumocfg: its files, its options, its time span, its seed.

    What a configuration says stays as it is, but for the options in `aeb_sumo.world.session.IMPOSED`; where it is
    silent on the step length, that is 0.1 s.

    Args:
        path: the configuration.
        drivers: what its drivers do wrong; None for nothing but that they need time to react to what takes them by
            surprise.

    Raises:
        InputError: the file is missing or is no configuration, or a file that it names is not well-formed.
    """
    config = read(path)
    return Scenario(
        name=str(path),
        options=("--configuration-file", str(config.path)),
        drivers=drivers or Profile(),
        seed=None,
        step_length=None if "step-length" in config.options else _STEP_LENGTH,
        duration=None,
        scale=_number(config.options.get("scale", "1")),
        output_prefix=config.options.get("output-prefix", ""),
    )


def _number(text: str) -> float:
    """A number; 1 for what is none, which is left to SUMO to refuse."""
    try:
        return float(text)
    except ValueError:
        return 1.0
