"""What a reproduction consists of, and running it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from aeb_sumo.drive import Case, Drive, drive_all
from aeb_sumo.reproduction.rows import Row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Drives", "System", "run_cases"]

Drives = Mapping[str, Drive]


@dataclass(frozen=True, kw_only=True)
class System:
    """One source: its test cases, its rows of the truth table, its figures.

    Attributes:
        name: of the strategy that it is about.
        source: the publication.
        cases: makes the test cases, by name.
        rows: makes the rows from the drives of those cases.
        figures: makes the figures, by name, each like one of the source.
    """

    name: str
    source: str
    cases: Callable[[], dict[str, Case]]
    rows: Callable[[Drives], list[Row]]
    figures: Callable[[Drives], "dict[str, Figure]"]


def run_cases(
    systems: Sequence[System], *, workers: int | None = None, done: Callable[[], None] | None = None
) -> dict[str, Drives]:
    """Run the cases of some systems in SUMO, several processes at a time (one simulation each).

    Args:
        systems: whose cases.
        workers: processes; None for one per processor.
        done: called after every case.
    """
    results: dict[str, dict[str, Drive]] = {system.name: {} for system in systems}
    jobs = {(system.name, name): case for system in systems for name, case in system.cases().items()}
    for (system_name, name), result in drive_all(jobs, workers=workers, done=done).items():
        results[system_name][name] = result
    return dict(results)
