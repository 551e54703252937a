"""Drawings as SVG for a page: colours are the page's own, for light, dark and paper; text stays text.

The same data give the same bytes: no date, no random ids.
"""

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from threading import Lock
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

__all__ = ["FAINT", "GRID", "INK", "PAGE", "SERIES", "VERDICTS", "canvas", "empty", "legend", "svg"]

# Stand-ins, which become variables of the page's style sheet.
INK, FAINT, GRID, PAGE = "#010101", "#020202", "#030303", "#040404"
SERIES = ("#010110", "#010111", "#010112", "#010113", "#010114", "#010115", "#010116")
"""Colours of groups of runs: first the baseline's, then those of systems."""
VERDICTS = {
    "avoided": "#010120",
    "mitigated": "#010121",
    "precautionary": "#010122",
    "unchanged": "#010123",
    "unneeded": "#010124",
    "worsened": "#010125",
    "induced": "#010126",
    "unknown": "#010127",
}
"""Colour of every verdict, in the order in which they are shown."""

_VARIABLES = {
    INK: "ink",
    FAINT: "faint",
    GRID: "grid",
    PAGE: "page",
    **{colour: f"series-{k}" for k, colour in enumerate(SERIES)},
    **{colour: f"verdict-{verdict}" for verdict, colour in VERDICTS.items()},
}
_WIDTH = 4.3  # inches; a phone shows this about as large as it is
_FITS = 48  # characters of two labels beside each other
_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "font.size": 9,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "text.color": INK,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.6,
    "path.simplify": True,
}
_LOCK = Lock()  # matplotlib takes its settings from one global place


@contextmanager
def canvas(height: float) -> Iterator[tuple[Figure, Axes]]:
    """An empty figure with one panel, in the report's style, which holds until the block ends; call `svg` inside.

    Args:
        height: in inches; the width is always the same.
    """
    with _LOCK, rc_context(_STYLE):
        figure = Figure(figsize=(_WIDTH, height), layout="constrained")
        figure.patch.set_alpha(0)
        axes = figure.subplots()
        axes.patch.set_alpha(0)
        yield figure, axes


def empty(axes: Axes, text: str) -> None:
    """Says in the panel that there is nothing to draw."""
    axes.text(0.5, 0.5, text, ha="center", va="center", color=FAINT, transform=axes.transAxes, wrap=True)
    axes.grid(visible=False)
    axes.set(xticks=[], yticks=[])


def legend(figure: Figure, axes: Axes) -> None:
    """A legend above the panel, in two columns where two labels are all there is and fit."""
    labels = axes.get_legend_handles_labels()[1]
    figure.legend(loc="outside upper left", ncols=2 if len(labels) <= 2 and len("".join(labels)) <= _FITS else 1)


def svg(figure: Figure, name: str, alt: str) -> str:
    """The figure as an `<svg>` element that can stand in a page beside others.

    Args:
        figure: to draw.
        name: unique in the page; all ids begin with it.
        alt: what it shows, in words.
    """
    buffer = io.StringIO()
    with rc_context({"svg.hashsalt": name}):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.S)
    text = re.sub(r"<style[^>]*>.*?</style>\s*", "", text, flags=re.S)
    view = re.search(r'viewBox="([^"]+)"', text)
    head = f'<svg class="drawing" role="img" aria-label="{escape(alt)}" viewBox="{view[1] if view else ""}">'
    text = head + text[text.index(">") + 1 :]
    text = text.replace("xlink:href", "href")
    used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', text))
    text = re.sub(r' id="([^"]+)"', lambda m: f' id="{name}-{m[1]}"' if m[1] in used else "", text)
    text = re.sub(r'(href="#|url\(#)', rf"\g<1>{name}-", text)
    text = re.sub(r"<!--.*?-->\s*", "", text, flags=re.S)
    text = re.sub(r" font-family: [^;\"]*;?", "", text)  # the page's own font
    text = re.sub(r"font: [^;\"]*?([\d.]+)px [^;\"]*", r"font-size: \1px", text)
    text = re.sub(r'(?<= d=")[^"]+', lambda m: re.sub(r"(\.\d\d)\d+", r"\1", " ".join(m[0].split())), text)
    text = re.sub("#0[0-9]{5}", lambda m: f"var(--{_VARIABLES[m[0]]})" if m[0] in _VARIABLES else m[0], text)
    return text.strip()
