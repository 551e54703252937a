"""Printing: tables on the terminal."""

import pandas as pd
from pandas.api.types import is_integer_dtype
from rich.console import Console
from rich.table import Table

__all__ = ["console", "print_frame", "print_summary"]

_WIDTH = 110  # of the output where there is no terminal to ask


def console(width: int = _WIDTH) -> Console:
    """The terminal, or a page of some width where there is none."""
    terminal = Console()
    return terminal if terminal.is_terminal else Console(width=width)


def print_summary(frame: pd.DataFrame, title: str) -> None:
    """Print a summary: one line per figure, a rule between sections."""
    table = Table(title=title, title_justify="left")
    table.add_column("figure")
    for column in frame.columns:
        table.add_column(str(column), justify="right")
    before = ""
    for (section, figure, unit), (_, row) in zip(frame.index.to_list(), frame.iterrows(), strict=True):
        if before and section != before:
            table.add_section()
        before = section
        label = f"{figure} [{unit}]".replace("[", r"\[") if unit else figure
        cells = [_cell(v, whole=not unit, sign=c == "difference") for c, v in row.items()]
        table.add_row(label, *cells)
    console().print(table)


def print_frame(frame: pd.DataFrame, title: str) -> None:
    """Print a table of the analysis as it is, turned so that its columns, which are many, become lines."""
    turned = frame.T
    table = Table(title=title, title_justify="left")
    table.add_column("")
    for column in turned.columns:
        table.add_column(" ".join(column) if isinstance(column, tuple) else str(column), justify="right")
    for name, row in turned.iterrows():
        whole = name in {"count", "arrived", "pending"} or is_integer_dtype(frame[name])
        table.add_row(str(name), *(_cell(v, whole=whole, sign=False) for v in row))
    console().print(table)


def _cell(value: float, *, whole: bool, sign: bool) -> str:
    if pd.isna(value):
        return "-"
    if whole:
        return f"{value:+.0f}" if sign else f"{value:.0f}"
    digits = 0 if abs(value) >= 1000 else 1 if abs(value) >= 10 else 2
    return f"{value:{'+' if sign else ''}.{digits}f}"
