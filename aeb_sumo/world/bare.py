"""SUMO by itself: stepped, and nothing read or commanded. The floor that runs are measured against."""

from time import process_time

import libsumo

from aeb_sumo.world.session import SumoError

__all__ = ["SAVING", "present", "save", "timed_steps"]

SAVING = ("--save-state.rng", "true", "--save-state.precision", "18")
"""SUMO options without which `save` loses the state of the random numbers, and digits."""


def present() -> int:
    """How many vehicles are on the network."""
    return int(libsumo.vehicle.getIDCount())


def save(name: str) -> None:
    """Write the world into a file of the folder for output, for SUMO's option `--load-state`.

    As all that SUMO writes, it gets the session's `output_prefix`, which leads there.
    """
    libsumo.simulation.saveState(name)


def timed_steps(steps: int) -> tuple[float, int]:
    """Simulate `steps` steps.

    Returns:
        The CPU time that they took [s], and the vehicles present after each, summed up; counting them is not timed.

    Raises:
        SumoError: SUMO gave up.
    """
    spent, vehicles = 0.0, 0
    try:
        for _ in range(steps):
            begin = process_time()
            libsumo.simulationStep()
            spent += process_time() - begin
            vehicles += libsumo.vehicle.getIDCount()
    except (libsumo.TraCIException, libsumo.FatalTraCIError) as error:
        raise SumoError(f"SUMO gave up: {' '.join(str(error).split())}") from None
    return spent, vehicles
