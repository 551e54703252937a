"""What a report is made of: quantities, figures, tables and sections. Data only; the template makes HTML of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from math import floor, isfinite, isinf, isnan, log10, nan

__all__ = ["Card", "Cell", "Figure", "Quantity", "Section", "Table", "Text", "count", "number"]

_ONE = {"crashes": "crash", "seeds": "seed", "verdicts": "verdict", "brakings": "braking"}
_MINUS, _GROUP = "−", " "


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A number of the report, with what is known of how far it can be trusted.

    Attributes:
        key: name of the number within the report, for whoever reads it by machine.
        value, low, high: the estimate and its 95 % interval; NaN where unknown, bounds also where there is none.
        n: what it rests on; 0 where that goes without saying, as for a count.
        of: what `n` counts.
        unit: behind the number; empty for none.
        whole: a count, shown without decimals.
        signed: a change, shown with its sign.
        note: why there is no interval, or what to keep in mind.
    """

    key: str
    value: float
    low: float = nan
    high: float = nan
    n: float = 0
    of: str = ""
    unit: str = ""
    whole: bool = False
    signed: bool = False
    note: str = ""

    @property
    def text(self) -> str:
        """The number with its unit."""
        return f"{self._number(self.value)}{self._unit}"

    @property
    def interval(self) -> str:
        """`95 %: a to b`; empty where there is none."""
        if isnan(self.low) or isnan(self.high):
            return ""
        unit = " %" if self.unit == "%" else ""
        return f"95 %: {self._number(self.low)} to {self._number(self.high)}{unit}"

    @property
    def rests_on(self) -> str:
        """`n = 20 seeds`; empty where that goes without saying."""
        decimals = 2 if self.n < 10 and self.n != int(self.n) else 0
        of = _ONE.get(self.of, self.of) if self.n == 1 else self.of
        return f"n = {number(self.n, decimals)} {of}" if self.of else ""

    @property
    def small(self) -> str:
        """All that belongs to the number, on one line."""
        return "; ".join(part for part in (self.interval, self.rests_on, self.note) if part)

    @property
    def _unit(self) -> str:
        return f" {self.unit}" if self.unit and not isnan(self.value) else ""

    @property
    def _decimals(self) -> int:
        if self.whole:
            return 0
        largest = max((abs(v) for v in (self.value, self.low, self.high) if isfinite(v)), default=0.0)
        if largest >= 1000:
            return 0
        # Two digits of what is below 1.
        return 1 if largest >= 10 else 2 if not 0 < largest < 0.1 else min(1 - floor(log10(largest)), 6)

    def _number(self, value: float) -> str:
        return number(value, self._decimals, signed=self.signed)


def number(value: float, decimals: int, *, signed: bool = False) -> str:
    """A number for people: a real minus, thin spaces between thousands, a dash for what is unknown."""
    if isnan(value):
        return "–"
    if isinf(value):
        return "∞" if value > 0 else f"{_MINUS}∞"
    text = f"{abs(value):,.{decimals}f}".replace(",", _GROUP)
    zero = not any(c in "123456789" for c in text)
    sign = "" if zero else _MINUS if value < 0 else "+" if signed else ""
    return sign + text


def count(key: str, value: float) -> Quantity:
    """A count: it is what was seen, so it has no interval."""
    return Quantity(key=key, value=float(value), whole=True)


Text = tuple[str | Quantity, ...]
"""A paragraph."""

Cell = str | Quantity
"""Of a table."""


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A drawing.

    Attributes:
        id: unique in the report.
        title: what is drawn.
        svg: the drawing, an `<svg>` element.
        alt: the same in words, for those who cannot see it.
        note: how to read it.
    """

    id: str
    title: str
    svg: str
    alt: str
    note: str = ""


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table; its first column names the rows, or groups of them that have the same name.

    Attributes:
        id: unique in the report.
        title: what it lists.
        head: names of the columns.
        rows: cells, as many per row as `head` has.
        note: how to read it.
        folded: shown only when asked for.
    """

    id: str
    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    note: str = ""
    folded: bool = False

    @property
    def grouped(self) -> bool:
        """Whether several rows have the same name."""
        return len(self.blocks) < len(self.rows)

    @property
    def blocks(self) -> list[list[Sequence[Cell]]]:
        """Rows, those together that have the same name."""
        return [list(rows) for _, rows in groupby(self.rows, key=lambda row: row[0])]


@dataclass(frozen=True, kw_only=True)
class Card:
    """The answer for one group of runs.

    Attributes:
        title: the group.
        headline: in large letters.
        lines: what stands below it, each with its label.
    """

    title: str
    headline: Text
    lines: Sequence[tuple[str, Text]] = ()


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of the report under one heading.

    Attributes:
        id: unique in the report.
        title: its heading.
        cards: answers, above all else.
        text: paragraphs.
        figures, tables: in order; figures come first.
        terms: explained terms, each with its definition.
        code: lines for a shell, each block with its caption.
    """

    id: str
    title: str
    cards: Sequence[Card] = ()
    text: Sequence[Text] = ()
    figures: Sequence[Figure] = ()
    tables: Sequence[Table] = ()
    terms: Sequence[tuple[str, str]] = ()
    code: Sequence[tuple[str, str]] = ()
