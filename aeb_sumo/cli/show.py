"""Printing: tables on the terminal."""

from collections.abc import Iterator

import pandas as pd
from pandas.api.types import is_integer_dtype
from rich.console import Console
from rich.table import Table

__all__ = ["console", "print_effect", "print_frame", "print_groups", "print_pairs", "print_summary"]

_CHANGE = ("difference", "low", "high", "percent")
_WIDTH = 110  # of the output where there is no terminal to ask
_LABEL, _COLUMN = 24, 16  # of a table with a column per group, our assumption: narrower, no name can be read


def console(width: int = _WIDTH) -> Console:
    """The terminal, or a page of some width where there is none."""
    terminal = Console()
    return terminal if terminal.is_terminal else Console(width=width)


def print_summary(frame: pd.DataFrame, title: str) -> None:
    """Print a summary: one line per figure, a rule between sections; many groups in several tables."""
    for some in _side_by_side(frame):
        table = _table("figure", [str(column) for column in some.columns], title)
        before = ""
        for (section, figure, unit), (_, row) in zip(some.index.to_list(), some.iterrows(), strict=True):
            if before and section != before:
                table.add_section()
            before = section
            label = f"{figure} [{unit}]".replace("[", r"\[") if unit else figure
            cells = [_cell(v, whole=not unit, sign=c == "difference") for c, v in row.items()]
            table.add_row(label, *cells)
        console().print(table)


def print_frame(frame: pd.DataFrame, title: str) -> None:
    """Print a table of the analysis as it is, turned so that its columns, which are many, become lines."""
    for some in _side_by_side(frame.T):
        names = [" ".join(column) if isinstance(column, tuple) else str(column) for column in some.columns]
        table = _table("", names, title)
        for name, row in some.iterrows():
            whole = name in {"count", "arrived", "pending"} or is_integer_dtype(frame[name])
            table.add_row(str(name), *(_cell(v, whole=whole, sign=False) for v in row))
        console().print(table)


def _side_by_side(frame: pd.DataFrame) -> Iterator[pd.DataFrame]:
    """As many columns at a time as can be read beside each other."""
    at_once = max(1, (console().width - _LABEL) // _COLUMN)
    for first in range(0, len(frame.columns), at_once):
        yield frame.iloc[:, first : first + at_once]


def _table(first: str, names: list[str], title: str) -> Table:
    table = Table(title=title, title_justify="left")
    table.add_column(first)
    for name in names:
        table.add_column(name, justify="right", overflow="fold")
    return table


def print_groups(frame: pd.DataFrame, title: str) -> None:
    """Print a table of the analysis with a row per group and something else, one table per group."""
    for group, rows in frame.groupby(level="group", sort=False):
        print_frame(rows.droplevel("group"), f"{title}: {group}")


def print_pairs(frame: pd.DataFrame, title: str) -> None:
    """Print `analysis.pair_counts`, one table per group: what became of the crashes of the baseline."""
    names = ("count", "primary", "intervened", "diverged", "percent", "low", "high")
    for group, rows in frame.groupby(level="group", sort=False):
        table = Table(title=f"{title}: {group}", title_justify="left")
        for name in ("", "crashes", "of these primary", "an AEB of them acted", "none did", "%", "95 % from", "to"):
            table.add_column(name, justify="right" if name else "left")
        for outcome, row in rows.droplevel("group").iterrows():
            cells = [_cell(row[name], whole=is_integer_dtype(frame[name]), sign=False) for name in names]
            table.add_row(str(outcome), *cells)
        console().print(table)


def print_effect(frame: pd.DataFrame, title: str) -> None:
    """Print `analysis.effect` or `traffic_price`, one table per group, and below it what its notes say."""
    for group, rows in frame.groupby(level="group", sort=False):
        table = Table(title=f"{title}: {group}", title_justify="left")
        for name in ("", "baseline", "with AEB", "difference", "95 % from", "to", "%"):
            table.add_column(name, justify="left" if not name else "right")
        for (_, figure, unit), (_, row) in zip(rows.index.to_list(), rows.iterrows(), strict=True):
            label = f"{figure} [{unit}]".replace("[", r"\[") if unit else figure
            worlds = (_cell(row[c], whole=False, sign=False) for c in ("baseline", "with_aeb"))
            table.add_row(label, *worlds, *(_cell(row[c], whole=False, sign=True) for c in _CHANGE))
        console().print(table)
        for note, some in rows[rows["note"] != ""].groupby("note", sort=False):
            figures = [figure.strip() for figure in some.index.get_level_values("figure")]
            console().print(f"{note}: {'all others' if len(some) > len(rows) / 2 else ', '.join(figures)}")


def _cell(value: float, *, whole: bool, sign: bool) -> str:
    if pd.isna(value):
        return "-"
    if whole:
        return f"{value:+.0f}" if sign else f"{value:.0f}"
    digits = 0 if abs(value) >= 1000 else 1 if abs(value) >= 10 else 2
    return f"{value:{'+' if sign else ''}.{digits}f}"
