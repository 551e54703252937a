"""How groups of runs look in every drawing, and the drawing of distributions."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.report.drawing import SERIES, canvas, empty, legend, svg
from analysis.report.matching import is_baseline
from analysis.report.parts import Figure, number

__all__ = ["Look", "ecdf", "looks"]

_STYLES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (6, 2, 1, 2)), (0, (1, 1.2)), (0, (3, 1, 1, 1, 1, 1)), (0, (9, 3)))
_LONG = 34  # characters that a legend has room for


@dataclass(frozen=True)
class Look:
    """Colour, style of lines, which tells groups apart in black and white, and a name that fits a legend."""

    colour: str
    style: Any
    short: str


def looks(groups: Iterable[str]) -> dict[str, Look]:
    """A look for every group; baselines are grey, and the first of them solid."""
    result, systems = {}, 0
    for k, group in enumerate(groups):
        if is_baseline(group):
            colour = SERIES[0]
        else:
            colour = SERIES[1 + systems % (len(SERIES) - 1)]
            systems += 1
        short = group if len(group) <= _LONG else group[: _LONG - 1] + "…"
        result[group] = Look(colour, _STYLES[k % len(_STYLES)], short)
    return result


def ecdf(
    name: str,
    title: str,
    values: Mapping[str, NDArray[np.float64]],
    look: Mapping[str, Look],
    *,
    label: str,
    events: str,
    top: float = np.inf,
) -> Figure:
    """Share of the events at or below every value, by group; what is not finite is left out and said.

    Args:
        name: id of the figure.
        title: of it.
        values: of every event, by group.
        look: of the groups.
        label: of the axis, quantity and unit.
        events: what they are.
        top: the axis ends there at the latest.
    """
    known = {g: np.sort(v[np.isfinite(v)]) for g, v in values.items()}
    quantity = label.partition(" [")[0]
    parts, left_out = [], 0
    for group, v in known.items():
        if v.size:
            low, mid, high = (number(float(np.quantile(v, q)), 1) for q in (0.25, 0.5, 0.75))
            parts.append(f"{group}: {v.size} {events}, quartiles {low}, {mid} and {high}")
        left_out += int(values[group].size - v.size)
    alt = f"Distribution of {quantity}. " + ("; ".join(parts) + "." if parts else f"There are no {events}.")
    with canvas(2.7) as (figure, axes):
        end = min(1.04 * max((float(v[-1]) for v in known.values() if v.size), default=1.0) or 1.0, top)
        for group, v in known.items():
            if v.size:
                x = np.concatenate([[min(0.0, v[0])], v, [max(end, v[-1])]])
                y = np.concatenate([np.arange(v.size + 1) / v.size * 100, [100.0]])
                axes.step(x, y, where="post", color=look[group].colour, ls=look[group].style,
                          label=f"{look[group].short} (n = {v.size})")  # fmt: skip
        if parts:
            axes.set(xlabel=label, ylabel=f"share of {events} [%]", ylim=(0, 102))
            axes.set_xlim(0, end)
            legend(figure, axes)
        else:
            empty(axes, f"no {events}")
        drawn = svg(figure, name, alt)
    note = f"Share of {events} at or below a value." + (
        f" {left_out} without a finite value left out." if left_out else ""
    )
    return Figure(id=name, title=title, svg=drawn, alt=alt, note=note)
