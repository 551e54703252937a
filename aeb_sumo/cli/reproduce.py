"""`aeb-sumo reproduce`."""

import json
import os
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click
import numpy as np
from rich.progress import Progress
from rich.table import Table

from aeb_sumo import reproduction
from aeb_sumo.cli.show import console
from aeb_sumo.errors import InputError
from aeb_sumo.reproduction import Row, System, Verdict
from aeb_sumo.reproduction.figures import save

__all__ = ["reproduce"]

_WIDTH = 150  # of the printed table where there is no terminal to ask


@click.command()
@click.argument("systems", nargs=-1, metavar="[SYSTEM]...")
@click.option("--json", "json_file", type=click.Path(path_type=Path, dir_okay=False), help="Write the rows here too.")
@click.option(
    "--figures", type=click.Path(path_type=Path, file_okay=False), help="Folder for figures like the sources'."
)
@click.option(
    "--format", "kind", type=click.Choice(["svg", "png"]), default="svg", show_default=True, help="Of figures."
)
@click.option("--workers", type=click.IntRange(1), help="Processes. [default: one per processor]")
@click.option("--quiet", is_flag=True, help="Print the misses only, and the count.")
def reproduce(
    systems: tuple[str, ...], json_file: Path | None, figures: Path | None, kind: str, workers: int | None, quiet: bool
) -> int:
    """Run the published tests of SYSTEM (all, if none is given) in SUMO; print the truth table row by row.

    Exit status 1 when a row marked R (reproducible) or C (with a calibrated parameter) is out of tolerance.
    """
    chosen = [reproduction.load(name) for name in dict.fromkeys(systems or reproduction.names())]
    for folder in (json_file and json_file.parent, figures):
        if folder is not None:
            _make(folder)
    cases = sum(len(system.cases()) for system in chosen)
    terminal = console(_WIDTH)
    with Progress(console=console(_WIDTH), disable=not terminal.is_terminal or quiet, transient=True) as bar:
        task = bar.add_task(f"{cases} test cases in SUMO", total=cases)
        drives = reproduction.run_cases(chosen, workers=workers, done=lambda: bar.advance(task))
    rows = {system.name: system.rows(drives[system.name]) for system in chosen}
    for system in chosen:
        _print(system, rows[system.name], missed_only=quiet)
    counted = [row for part in rows.values() for row in part if row.counted]
    missed = [row for row in counted if row.missed]
    still = sum(not row.driven for row in counted)
    click.echo(
        f"{len(counted) - len(missed)} of {len(counted)} rows marked R or C agree"
        + (f", {still} of them arithmetic or geometry on printed numbers" if still else "")
        + (f"; out of tolerance: {', '.join(f'{r.id} ({r.quantity})' for r in missed)}" if missed else "")
    )
    if json_file is not None:
        records = [_record(name, row) for name, part in rows.items() for row in part]
        text = json.dumps(records, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
        try:
            json_file.write_text(text, encoding="utf-8")
        except OSError as error:
            raise InputError(f"cannot write --json {json_file}: {error.strerror}") from None
    if figures is not None:
        for system in chosen:
            paths = save(system.figures(drives[system.name]), figures / system.name, kind)
            click.echo(f"{len(paths)} figures in {figures / system.name}")
    return 1 if missed else 0


def _make(folder: Path) -> None:
    """Find out before the runs, not after."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {folder}: {error.strerror}") from None
    if not os.access(folder, os.W_OK):
        raise InputError(f"cannot write into the folder {folder}")


def _print(system: System, rows: list[Row], *, missed_only: bool) -> None:
    shown = [row for row in rows if row.missed or not missed_only]
    if not shown:
        return
    table = Table(title=f"{system.name}: {system.source}", title_justify="left")
    for name, justify in (("row", "left"), ("quantity", "left"), ("published", "right"), ("ours", "right")):
        table.add_column(name, justify=justify)  # type: ignore[arg-type]
    for name in ("tolerance", "kind", "verdict", "note"):
        table.add_column(name, style="dim" if name == "note" else None)
    for row in shown:
        unit = f" {row.unit}" if row.unit else ""
        table.add_row(
            row.id,
            row.quantity,
            _number(row.published) + unit,
            _number(row.ours) + unit,
            "" if row.tolerance is None else f"{row.tolerance:g}",
            row.verdict.value,
            _words(row),
            row.note,
        )
    console(_WIDTH).print(table)


def _number(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.2f}" if abs(value) < 100 else f"{value:.1f}"


def _words(row: Row) -> str:
    if row.agrees is None:
        return {Verdict.L: "input lost", Verdict.I: "contradicts itself", Verdict.N: "out of scope"}.get(
            row.verdict, "listed"
        )
    if row.verdict is Verdict.T:
        return "[dim]on target[/]" if row.agrees else "[dim]off target[/]"
    return "[green]agrees[/]" if row.agrees else "[bold red]MISSED[/]"


def _record(system: str, row: Row) -> dict[str, Any]:
    nothing = isinstance(row.ours, float) and not np.isfinite(row.ours)  # JSON has no nan
    values = asdict(row) | ({"ours": None} if nothing else {})
    return {"system": system, **values, "counted": row.counted, "missed": row.missed}
