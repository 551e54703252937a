"""`aeb-sumo bench`."""

import json
from pathlib import Path
from typing import Any

import click
from rich.progress import Progress
from rich.table import Table

from aeb_sumo import scenarios, strategies
from aeb_sumo.bench import COPIED, LARGEST, Line, Plan, Spread, load, machine
from aeb_sumo.bench import bench as measure
from aeb_sumo.cli.show import console
from aeb_sumo.drivers import profile
from aeb_sumo.errors import InputError

__all__ = ["bench"]

_WIDTH = 120  # of the table where there is no terminal to ask
_BEGIN = Plan.begin
_BUSY = 0.5  # processes; a machine with nothing else to do has fewer


@click.command()
@click.option("--scenario", help=f"What is simulated. [default: {COPIED}]")
@click.option("--sumocfg", type=click.Path(path_type=Path), help="Measure this SUMO configuration instead.")
@click.option("--vehicles", help=f"Sizes of the fleet, {COPIED} only: copies side by side. [default: 250,1000]")
@click.option("--strategy", default="zhao2025", show_default=True, help="AEBs, by name; also none.")
@click.option("--step-length", help="Seconds. [default: the scenario's, else 0.1]")
@click.option("--steps", type=click.IntRange(1), default=300, show_default=True, help="That are timed.")
@click.option(
    "--repeat", type=click.IntRange(1), default=3, show_default=True, help="Times, bare and equipped in turn."
)
@click.option(
    "--from", "begin", type=float, help=f"Simulated seconds before, without --vehicles. [default: {_BEGIN:g}]"
)
@click.option("--drivers", help="Driver profile, a name or a file.toml. [default: the scenario's; sumo with --sumocfg]")
@click.option("--json", "json_file", type=click.Path(path_type=Path, dir_okay=False), help="Write all of it here, too.")
@click.option("--quiet", is_flag=True, help="No progress bar, no table.")
def bench(
    scenario: str | None,
    sumocfg: Path | None,
    vehicles: str | None,
    strategy: str,
    step_length: str | None,
    begin: float | None,
    drivers: str | None,
    json_file: Path | None,
    quiet: bool,
    **counts: int,
) -> int:
    """Measure what an AEB in every car costs on top of SUMO: the same world stepped bare and equipped, in turn.

    --vehicles, --strategy and --step-length take several values with commas between; all combinations are measured.
    """
    if scenario is not None and sumocfg is not None:
        raise InputError("give one of --scenario and --sumocfg, not both")
    chosen = scenarios.from_sumocfg(sumocfg) if sumocfg is not None else scenarios.load(scenario or COPIED)
    if drivers is not None:
        chosen = chosen.varied(drivers=profile.load(drivers))
    plan = Plan(
        scenario=chosen,
        vehicles=_sizes(vehicles, chosen.name, begin),
        strategies=[strategies.load(name).name for name in _parts(strategy, "--strategy")],
        step_lengths=[None]
        if step_length is None
        else [_seconds(part) for part in _parts(step_length, "--step-length")],
        begin=_BEGIN if begin is None else begin,
        **counts,
    )
    if json_file is not None and not json_file.absolute().parent.is_dir():
        raise InputError(f"--json {json_file}: there is no folder {json_file.parent}")
    terminal, busy = console(_WIDTH), load()
    with Progress(console=terminal, disable=not terminal.is_terminal or quiet, transient=True) as bar:
        task = bar.add_task(chosen.name, total=plan.parts)
        lines = list(measure(plan, done=lambda: bar.advance(task)))
    about = machine(lines[0].sumo, busy)
    if json_file is not None:
        _write(json_file, {"machine": about, **counts, "lines": [line.record() for line in lines]})
    if not quiet:
        terminal.print(_table(lines, plan))
        click.echo(_machine(about))
        if busy > _BUSY:
            note = f"the machine had other work to do (load {busy:.1f}), which slows SUMO more than it slows the AEB"
            click.echo(f"aeb-sumo: note: {note}; measure on a quiet one", err=True)
    return 0


def _parts(text: str, option: str) -> list[str]:
    parts = [part.strip() for part in text.split(",")]
    if not all(parts) or len({*parts}) < len(parts):
        raise InputError(f"{option} takes different values with commas between, not {text!r}")
    return parts


def _sizes(text: str | None, scenario: str, begin: float | None) -> list[int | None]:
    if begin is not None and not 0 <= begin < float("inf"):
        raise InputError(f"--from must be 0 or more seconds, not {begin:g}")
    if text is None and (scenario != COPIED or begin is not None):
        return [None]
    if scenario != COPIED:
        raise InputError(f"--vehicles is for the scenario {COPIED} only, which can be copied; {scenario} is as it is")
    if begin is not None:
        raise InputError("--from excludes --vehicles, which says when a world is measured")
    sizes = [int(part) if part.isdecimal() else 0 for part in _parts(text or "250,1000", "--vehicles")]
    if not all(1 <= size <= LARGEST for size in sizes):
        raise InputError(f"--vehicles takes whole numbers from 1 to {LARGEST}, not {text!r}")
    return [*sizes]


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.001 <= value <= 10:
        raise InputError(f"--step-length takes seconds from 0.001 to 10, not {text!r}")
    return value


def _table(lines: list[Line], plan: Plan) -> Table:
    table = Table(
        title=f"{Path(plan.scenario.name).name}: CPU time of {plan.steps} steps, SUMO bare / with an AEB in every car, "
        f"median of {plan.repeat}",
        title_justify="left",
    )
    for name in (
        "vehicles", "strategy", "step\n\\[s]", "ratio", "from .. to", "ratio per\nvehicle-step",
        "us per\nvehicle-step", "vehicle-hours\nper core-hour", "peak\nmemory \\[MB]",
    ):  # fmt: skip
        table.add_column(name, justify="left" if name == "strategy" else "right")
    for line in lines:
        bare, equipped = line.bare, line.equipped
        table.add_row(
            f"{bare.vehicles:.0f} / {equipped.vehicles:.0f}",
            line.strategy,
            f"{bare.step_length:g}",
            f"{line.ratio.median:.2f}",
            _range(line.ratio),
            f"{line.ratio_per_vehicle.median:.2f}",
            f"{bare.microseconds.median:.2f} / {equipped.microseconds.median:.2f}",
            f"{bare.hours_per_hour:,.0f} / {equipped.hours_per_hour:,.0f}",
            f"{bare.memory:.0f} / {equipped.memory:.0f}",
        )
    return table


def _range(spread: Spread) -> str:
    return f"{spread.low:.2f} .. {spread.high:.2f}"


def _machine(about: dict[str, Any]) -> str:
    return "{cpu}, {cores} cores, {system}, Python {python}, SUMO {sumo}, aeb-sumo {aeb_sumo}".format(**about)


def _write(path: Path, content: dict[str, Any]) -> None:
    try:
        path.write_text(json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot write --json {path}: {error.strerror}") from None
