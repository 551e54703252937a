"""The command `aeb-sumo ncap`."""

from pathlib import Path
from typing import Any

import click
import numpy as np
import pandas as pd
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
from rich.table import Table
from rich.text import Text

from aeb_sumo import ncap as grid
from aeb_sumo import strategies
from aeb_sumo.cli.options import system_options
from aeb_sumo.cli.show import console
from aeb_sumo.errors import InputError
from aeb_sumo.parameters import differences

__all__ = ["ncap"]

_STYLES = {
    "green": "black on green",
    "yellow": "black on yellow",
    "orange": "black on dark_orange",
    "brown": "white on orange4",
    "red": "white on red",
}


@click.command()
@click.argument("strategy")
@system_options
@click.option("--mu", type=float, default=grid.MU, show_default=True, help="Friction coefficient of the road.")
@click.option("--workers", type=click.IntRange(1), help="Processes. [default: one per processor]")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Write one record per test to this file.")
@click.option("--quiet", is_flag=True, help="No progress bar, no tables.")
def ncap(
    strategy: str,
    sensing: str | None,
    parameters: dict[str, Any],
    mu: float,
    workers: int | None,
    target: Path | None,
    quiet: bool,
) -> int:
    """Test STRATEGY on the proving ground and print Euro NCAP's colour per test, and points.

    Car to car behind a standing, a moving and a braking lead at 100 and 50 % overlap, and a left turn across an e-bike.
    """
    brain = strategies.load(strategy, parameters)
    if target is not None and (target.is_dir() or not target.parent.is_dir()):
        raise InputError(f"--json {target}: {'a folder' if target.is_dir() else 'its folder does not exist'}")
    screen = Console(stderr=True)
    bar = Progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), console=screen, disable=quiet)
    with bar if screen.is_terminal else Progress(disable=True) as progress:
        task = progress.add_task(strategy, total=len(grid.GRID))
        rows = grid.run_grid(
            brain, cells=grid.GRID, sensing=sensing, mu=mu, workers=workers, done=lambda: progress.advance(task)
        )
    if target is not None:
        try:
            target.write_text(rows.to_json(orient="records", indent=1, double_precision=15) + "\n", encoding="utf-8")
        except OSError as error:
            raise InputError(f"cannot write --json {target}: {error.strerror}") from None
    if not quiet:
        _print(rows, " ".join(filter(None, (strategy, differences(brain)))))
    failed = rows[rows["error"] != ""]
    if len(failed):
        where = ", ".join(
            f"{grid.label(row['case'], row['overlap'])} at {row['test_speed_kmh']} km/h" for _, row in failed.iterrows()
        )
        raise InputError(f"{len(failed)} of {len(rows)} tests failed ({where}): {failed['error'].iloc[0]}")
    return 0


def _print(rows: pd.DataFrame, name: str) -> None:
    """One line per case and overlap, one column per test speed, then the points; below, what they mean."""
    first = rows.iloc[0]
    table = Table(title=f"{name}, sensing {first['sensing']}, mu {first['mu']:g}", title_justify="left")
    table.add_column("km/h", no_wrap=True)
    speeds = sorted(rows["test_speed_kmh"].unique())
    for speed in speeds:
        table.add_column(str(speed), justify="left", no_wrap=True)
    for heading in ("Euro NCAP %", "C-NCAP %", "UN R152", "windows"):
        table.add_column(heading, justify="right")
    for line, each in grid.points(rows).iterrows():
        if line == "all":
            table.add_section()
        cells = {
            row["test_speed_kmh"]: _cell(row)
            for _, row in rows.iterrows()
            if grid.label(row["case"], row["overlap"]) == line
        }
        table.add_row(
            str(line),
            *(cells.get(speed, "") for speed in speeds),
            *(_percent(each[f"{protocol}_percent"]) for protocol in ("euroncap", "cncap")),
            *(_share(each[f"{test}_passed"], each[f"{test}_cells"]) for test in ("r152", "windows")),
        )
    page = console()
    page.print(table)
    for paragraph in grid.LEGEND:
        page.print(Text(paragraph))


def _cell(row: pd.Series) -> Text:
    """Letter of the colour and impact speed [km/h]: `G`, `Y 8`; `!` for a test that failed."""
    if row["error"]:
        return Text("!")
    impact, colour = row["impact_speed_kmh"], row["euroncap_colour"]
    speed = "" if np.isnan(impact) else " <1" if impact < 1 else f" {impact:.0f}"
    return Text(colour[0].upper() + speed, style=_STYLES[colour])


def _percent(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.0f}"


def _share(passed: float, cells: float) -> str:
    return f"{passed:.0f}/{cells:.0f}" if cells else "-"
