"""Rows of the truth table: what was published, what we measure, and whether that agrees."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

__all__ = ["Row", "Verdict", "agrees", "listed", "within"]


class Verdict(StrEnum):
    """What a row of the truth table is (shared/seeds.md 6)."""

    R = "R"
    """Reproducible."""
    C = "C"
    """Reproducible with a calibrated parameter, which the note names."""
    T = "T"
    """The target of a calibration: compared, but no proof of anything, so not counted."""
    I = "I"  # noqa: E741 - the truth table's own letter
    """The source contradicts itself; listed with the reason, not counted."""
    L = "L"
    """The source's input is lost; listed, not counted."""
    N = "-"
    """Not for this project; listed, not counted."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One number of one source.

    Attributes:
        id: of the truth table, for example `Z15`.
        quantity: what it is, with the case.
        unit: of the numbers, empty for words.
        published: as printed.
        ours: as measured.
        tolerance: largest difference that counts as agreement, in `unit`; None where the words must be equal.
        verdict: what kind of row it is.
        agrees: ours is within the tolerance; None where there is nothing to compare.
        note: calibrated parameter, contradiction, or how ours was measured.
        driven: measured in a run; otherwise arithmetic or geometry on printed numbers.
    """

    id: str
    quantity: str
    unit: str
    published: float | str
    ours: float | str
    tolerance: float | None
    verdict: Verdict
    agrees: bool | None
    note: str = ""
    driven: bool = True

    @property
    def counted(self) -> bool:
        """It is marked R or C."""
        return self.verdict in {Verdict.R, Verdict.C}

    @property
    def missed(self) -> bool:
        """It is counted and does not agree."""
        return self.counted and self.agrees is not True


def within(
    id: str,  # noqa: A002
    quantity: str,
    unit: str,
    published: float,
    ours: float,
    tolerance: float,
    verdict: Verdict,
    note: str = "",
    *,
    driven: bool = True,
) -> Row:
    """A number that has to agree within a tolerance; one that is not there (nan) does not."""
    good = bool(abs(ours - published) <= tolerance + 1e-9)
    return Row(
        id=id, quantity=quantity, unit=unit, published=published, ours=float(ours), tolerance=tolerance,
        verdict=verdict, agrees=good, note=note, driven=driven,
    )  # fmt: skip


def agrees(
    id: str,  # noqa: A002
    quantity: str,
    published: str,
    ours: str,
    verdict: Verdict,
    *,
    good: bool | None = None,
    note: str = "",
    driven: bool = True,
) -> Row:
    """A statement: the words have to be the same, unless `good` says whether it holds."""
    return Row(
        id=id, quantity=quantity, unit="", published=published, ours=ours, tolerance=None, verdict=verdict,
        agrees=published == ours if good is None else bool(good), note=note, driven=driven,
    )  # fmt: skip


def listed(
    id: str,  # noqa: A002
    quantity: str,
    unit: str,
    published: float | str,
    ours: float | str,
    verdict: Verdict,
    note: str,
    tolerance: float | None = None,
) -> Row:
    """A row that only says what is wrong with the source, beside what we get and by how much that differs."""
    if tolerance is not None and not isinstance(published, str) and not isinstance(ours, str):
        note += f"; off by {abs(ours - published):.2f}"
    value = ours if isinstance(ours, str) or np.isfinite(ours) else "-"
    return Row(
        id=id, quantity=quantity, unit=unit, published=published, ours=value, tolerance=tolerance, verdict=verdict,
        agrees=None, note=note,
    )  # fmt: skip
