"""`aeb-sumo sweep`."""

from pathlib import Path
from typing import Any

import click
import pandas as pd
from matplotlib.figure import Figure
from rich.progress import Progress

import analysis
from aeb_sumo import results as store
from aeb_sumo import scenarios
from aeb_sumo.cli.options import new_folder, scenario_options, system_options
from aeb_sumo.cli.show import console, print_frame
from aeb_sumo.drivers import profile
from aeb_sumo.errors import InputError
from aeb_sumo.parameters import parse
from aeb_sumo.results import Results
from aeb_sumo.sweep import sweep as run_all
from aeb_sumo.verdicts import Choice

__all__ = ["sweep"]

_BY = ("target_vclass", "place")


@click.command()
@click.argument("scenario")
@click.argument("vary", metavar="NAME=VALUE,VALUE,...")
@click.option("--strategy", default="staged", show_default=True, help="The AEB.")
@system_options
@scenario_options
@click.option("--drivers", help="Driver profile, a name or a file.toml. [default: the scenario's]")
@click.option("--penetration", type=float, help="Share of cars equipped, 0..1. [default: 1]")
@click.option("--seeds", type=click.IntRange(1), default=3, show_default=True, help="Seeds 1 to N.")
@click.option("--duration", type=float, help="Simulated seconds of every run. [default: the scenario's]")
@click.option("--verdicts", default="all", show_default=True, help="all or sample:N per run.")
@click.option("--out", help="Folder for the tables. [default: none, only printed]")
@click.option("--figure", type=click.Path(path_type=Path, dir_okay=False), help="Precision over recall, .svg or .png.")
@click.option("--workers", type=click.IntRange(1), help="Processes. [default: one per processor]")
def sweep(
    scenario: str,
    vary: str,
    strategy: str,
    sensing: str | None,
    parameters: dict[str, Any],
    variation: dict[str, Any],
    drivers: str | None,
    seeds: int,
    verdicts: str,
    out: str | None,
    figure: Path | None,
    **options: Any,
) -> int:
    """How many interventions are needed, and how many crashes avoided, with one parameter at several VALUEs.

    For example the trigger threshold: aeb-sumo sweep highway brake_ttc=0.5,0.9,1.5,2.5 --set warn_ttc=2.62
    """
    name, values = _values(vary)
    if not Choice.parse(verdicts).size:
        raise InputError("--verdicts none leaves nothing to sweep for; give all or sample:N")
    if figure is not None and (figure.suffix not in {".svg", ".png"} or not figure.parent.is_dir()):
        raise InputError(f"--figure {figure}: name a file .svg or .png in an existing folder")
    chosen = scenarios.load(scenario).varied(**variation, drivers=None if drivers is None else profile.load(drivers))
    folder = None if out is None else new_folder(out)
    terminal, runs = console(), (len(values) + 1) * seeds
    with Progress(console=terminal, disable=not terminal.is_terminal, transient=True) as bar:
        task = bar.add_task(f"{runs} runs of {scenario}", total=runs)
        results = run_all(
            chosen, strategy, name, values, seeds=range(1, seeds + 1), parameters=parameters, sensing=sensing,
            verdicts=verdicts, done=lambda: bar.advance(task), **options,
        )  # fmt: skip
    if folder is not None:
        for one in results:
            store.write(one, folder.name)
        click.echo(f"Tables in {folder.name}.")
    parts = {
        f"{name}={value:g}": Results.joined([*results[:seeds], *results[(k + 1) * seeds : (k + 2) * seeds]])
        for k, value in enumerate(values)
    }
    data = {key: analysis.Dataset.of(part) for key, part in parts.items()}
    print_frame(_together(data), f"{scenario}, {strategy}: interventions that were needed, crashes avoided")
    for by in _BY:
        print_frame(_together(data, by), f"{scenario}, {strategy}: by {by.replace('_', ' ')}")
    if figure is not None:
        _draw(_together(data), f"{scenario}, {strategy}, {seeds} seeds").savefig(figure, dpi=160)
    return 0


def _values(text: str) -> tuple[str, list[float]]:
    name, _, numbers = text.partition("=")
    values = [parse((f"{name}={number}",))[name] for number in numbers.split(",")] if name and numbers else []
    if not values or not all(isinstance(v, int | float) for v in values) or len({*values}) < len(values):
        raise InputError(f"write NAME=VALUE,VALUE,... with different numbers, such as brake_ttc=0.5,1; not {text!r}")
    return name, values


def _together(data: dict[str, analysis.Dataset], by: str | None = None) -> pd.DataFrame:
    """Precision and recall, value by value."""
    frames = {key: analysis.precision_recall(part, by) for key, part in data.items()}
    return pd.concat(frames).droplevel(1)  # the group, of which each has one


def _draw(frame: pd.DataFrame, title: str) -> Figure:
    """Precision over recall, with the intervals of both."""
    figure = Figure(figsize=(6.0, 4.2), layout="constrained")
    axes = figure.subplots()
    percent = 100 * frame
    errors = {
        what: [percent[what] - percent[f"{what}_low"], percent[f"{what}_high"] - percent[what]]
        for what in ("recall", "precision")
    }
    axes.errorbar(
        percent["recall"], percent["precision"], xerr=errors["recall"], yerr=errors["precision"],
        marker="o", capsize=3, color="#0072B2", ecolor="#9BC3E0",
    )  # fmt: skip
    for value, row in percent.iterrows():
        axes.annotate(
            str(value), (row["recall"], row["precision"]), xytext=(6, 6), textcoords="offset points", color="0.3"
        )
    axes.set_xlabel("recall: crashes avoided of those that cars with the AEB would strike [%]")
    axes.set_ylabel("precision: interventions that avoided\nor mitigated a crash [%]")
    axes.set_title(f"{title}; bars: 95 %", fontsize=10)
    axes.set_xlim(-4, 104)
    axes.set_ylim(-4, 104)
    axes.grid(color="0.9")
    return figure
