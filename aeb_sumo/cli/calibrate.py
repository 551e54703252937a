"""`aeb-sumo calibrate`."""

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path

import click
from matplotlib.figure import Figure
from rich.markup import escape
from rich.progress import Progress
from rich.table import Table

from aeb_sumo.calibration import FITTED, GRID, SHARES, TARGET, Observed, best, lines, observe_all, with_value
from aeb_sumo.cli.show import console
from aeb_sumo.drivers import profile
from aeb_sumo.errors import InputError
from analysis import poisson_rate

__all__ = ["calibrate"]

_WIDTH = 140  # of the printed table where there is no terminal to ask


@click.command()
@click.option("--drivers", default="highway", show_default=True, help="Driver profile, a name or a file.toml.")
@click.option("--seeds", type=click.IntRange(1), default=4, show_default=True, help="Seeds 1 to N.")
@click.option("--duration", type=float, default=600.0, show_default=True, help="Simulated seconds of every run.")
@click.option("--fit", is_flag=True, help=f"Try values of {FITTED} and keep the best.")
@click.option("--sweep", is_flag=True, help="Count crashes at five shares of time with the eyes off the road.")
@click.option("--out", type=click.Path(path_type=Path), help="New file: the fitted profile, NAME.toml.")
@click.option("--figure", type=click.Path(path_type=Path, dir_okay=False), help="Of the sweep, .svg or .png.")
@click.option("--workers", type=click.IntRange(1), help="Processes. [default: one per processor]")
def calibrate(
    drivers: str,
    seeds: int,
    duration: float,
    fit: bool,
    sweep: bool,
    out: Path | None,
    figure: Path | None,
    workers: int | None,
) -> int:
    """Run the highway without AEB and print what its drivers do beside the evidence."""
    base = profile.load(drivers)
    text = Path(drivers).read_text(encoding="utf-8") if drivers.endswith(".toml") else profile.text(drivers)
    if out is not None and (not fit or out.suffix != ".toml" or out.exists() or not out.parent.is_dir()):
        raise InputError(f"--out {out}: name a new file.toml in an existing folder for the profile that --fit finds")
    if figure is not None and (not sweep or figure.suffix not in {".svg", ".png"} or not figure.parent.is_dir()):
        raise InputError(f"--figure {figure}: name a file .svg or .png in an existing folder, and give --sweep")
    if fit and sweep:
        raise InputError("--fit and --sweep are two runs: give one of them")
    name, values = ("glances.share", SHARES) if sweep else (FITTED, GRID)
    if out is not None:
        _check_text(drivers, text, name)
    profiles = [with_value(base, name, value) for value in values] if fit or sweep else [base]
    terminal = console()
    with Progress(console=terminal, disable=not terminal.is_terminal, transient=True) as bar:
        task = bar.add_task(f"{len(profiles) * seeds} runs of the highway", total=len(profiles) * seeds)
        seen = observe_all(profiles, range(1, seeds + 1), duration, workers=workers, done=lambda: bar.advance(task))
    if not (fit or sweep):
        _print(drivers, seen[0])
        return 0
    _print_values(name, values, seen)
    if fit:
        value = best(values, seen)
        click.echo(f"nearest to {TARGET:.1f} near-crashes per crash: {name} = {value:g}")
        _print(f"{drivers}, {name} = {value:g}", seen[values.index(value)])
        if out is not None:
            _write(out, _set(text, name, value))
    if figure is not None:
        _draw(values, seen, duration, seeds).savefig(figure, dpi=160)
    return 0


def _print(title: str, seen: Observed) -> None:
    table = Table(title=f"highway without AEB, drivers: {title}", title_justify="left")
    for column in ("", "here", "evidence", "mark"):
        table.add_column(column, justify="left")
    for line in lines(seen):
        table.add_row(escape(line.quantity), line.here, line.evidence, line.mark)
    console(_WIDTH).print(table)


def _print_values(name: str, values: Sequence[float], seen: Sequence[Observed]) -> None:
    table = Table(title=f"highway without AEB, {name}", title_justify="left")
    for column in (name, "near-crashes", "crashes", "ratio", "secondary", "eyes off [%]", "vehicle-km"):
        table.add_column(column, justify="right")
    for value, o in zip(values, seen, strict=True):
        away = 100 * o.away / o.driving if o.driving else 0.0
        counts = (o.near_crashes, o.crashes, f"{o.ratio:.1f}", o.secondary, f"{away:.1f}", f"{o.vehicle_km:.0f}")
        table.add_row(f"{value:g}", *(str(c) for c in counts))
    console().print(table)


def _set(text: str, name: str, value: float) -> str:
    """A profile's text with one value changed; it keeps its comments. Unchanged if it has no such section."""
    section, _, key = name.partition(".")
    parts = re.split(rf"^\[{section}\]", text, maxsplit=1, flags=re.M)
    if len(parts) < 2:
        return text
    end = re.search(r"^\[", parts[1], re.M)
    at = end.start() if end else len(parts[1])
    line = f"{key} = {value!r}"
    body, found = re.subn(rf"^{key}\s*=\s*[^\s#]+", line, parts[1][:at], flags=re.M)
    return f"{parts[0]}[{section}]" + (body if found else f"\n{line}" + body) + parts[1][at:]


def _check_text(drivers: str, text: str, name: str) -> None:
    """Find out before the runs that the file is written as `_set` needs it."""
    section, _, key = name.partition(".")
    probe = 123.25
    try:
        found = tomllib.loads(_set(text, name, probe))[section][key]
    except (tomllib.TOMLDecodeError, LookupError, TypeError):
        found = None
    if found != probe:
        raise InputError(f"--out: cannot change {name} in {drivers}; write it as [{section}] with a line {key} = ...")


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}") from None
    click.echo(f"{path}: the fitted profile; aeb-sumo run highway --drivers {path}")


def _draw(shares: Sequence[float], seen: Sequence[Observed], duration: float, seeds: int) -> Figure:
    """Crash rates over the share of time with the eyes off the road, with exact Poisson intervals."""
    figure = Figure(figsize=(6.4, 3.8), layout="constrained")
    axes = figure.subplots()
    rates = [poisson_rate(o.crashes, o.vehicle_km / 1e3) for o in seen]
    x = [100 * share for share in shares]
    errors = [[r.rate - r.low for r in rates], [r.high - r.rate for r in rates]]
    axes.errorbar(x, [r.rate for r in rates], yerr=errors, marker="o", capsize=4, color="#0072B2")
    for at, rate, o in zip(x, rates, seen, strict=True):
        axes.annotate(str(o.crashes), (at, rate.rate), xytext=(5, 6), textcoords="offset points", color="0.3")
    axes.set_xlabel("time with the eyes off the road, as drawn [%]")
    axes.set_ylabel("primary rear-end crashes per 1,000 km")
    axes.set_title(f"Highway without AEB, {seeds} seeds of {duration:g} s; numbers: crashes; bars: 95 %", fontsize=10)
    axes.set_ylim(bottom=0)
    axes.margins(x=0.08)
    axes.grid(color="0.9")
    return figure
