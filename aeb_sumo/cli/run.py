"""`aeb-sumo run`."""

import shutil
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import FrameType
from typing import Any

import click
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

import analysis
from aeb_sumo import results as store
from aeb_sumo import scenarios, strategies
from aeb_sumo.ceilings import ceilings
from aeb_sumo.cli.options import new_folder, scenario_options, system_options
from aeb_sumo.cli.show import print_frame, print_pairs, print_summary
from aeb_sumo.compiled import announce
from aeb_sumo.drivers import profile
from aeb_sumo.equipment import Equipment, equipment
from aeb_sumo.errors import InputError
from aeb_sumo.results import Results
from aeb_sumo.simulate import Progress as Step
from aeb_sumo.simulate import run as simulate

__all__ = ["run"]

_LONG_STEP = 0.2  # s, longer than the cycle of any automotive sensor


@click.command()
@click.argument("scenario", required=False)
@click.option("--sumocfg", type=click.Path(path_type=Path), help="Run this SUMO configuration instead of SCENARIO.")
@click.option("--strategy", help="The AEB; none for the baseline. [default: zhao2025]")
@system_options
@click.option("--penetration", type=float, help="Share of cars equipped, 0..1. [default: 1]")
@click.option("--equip", metavar="[KIND:]SYSTEM[/SUITE]=SHARE,...", help="Several AEBs, or shares by vehicle kind.")
@scenario_options
@click.option("--seed", type=click.IntRange(0, 2**31 - 1), help="Of SUMO and of the drivers. [default: the scenario's]")
@click.option("--duration", type=float, help="Simulated seconds. [default: the scenario's]")
@click.option("--step-length", type=float, help="Seconds. [default: the scenario's, else 0.1]")
@click.option("--drivers", help="Driver profile, a name or a file.toml. [default: the scenario's; sumo with --sumocfg]")
@click.option("--blockage", type=float, help="Seconds that crashed vehicles stand. [default: 60]")
@click.option("--interval", type=float, default=60.0, show_default=True, help="Seconds per row of table traffic.")
@click.option(
    "--verdicts",
    default="none",
    show_default=True,
    help="Interventions judged by a fork of the world without them: all, none or sample:N.",
)
@click.option(
    "--poll",
    default="needed",
    show_default=True,
    help="Vehicles read in a step: needed, where a conflict is possible, or every, which is slow and gives the same.",
)
@click.option("--out", help="Folder for the tables, or an fsspec URL. [default: none, only printed]")
@click.option("--compare", is_flag=True, help="Run the baseline too, same seed, and print both side by side.")
@click.option(
    "--ceilings", "with_ceilings", is_flag=True, help="Ask of every crash of the baseline who could have avoided it."
)
@click.option("--quiet", is_flag=True, help="No progress bar, no summary.")
def run(
    scenario: str | None,
    sumocfg: Path | None,
    strategy: str | None,
    sensing: str | None,
    penetration: float | None,
    equip: str | None,
    parameters: dict[str, Any],
    drivers: str | None,
    variation: dict[str, Any],
    out: str | None,
    compare: bool,
    with_ceilings: bool,
    quiet: bool,
    **options: Any,
) -> int:
    """Simulate SCENARIO with an AEB fleet and print crashes, interventions and throughput.

    SCENARIO is one of 221, 321, 322, 601, b2, highway, track, w0, w1, w2, w2t.

    --equip takes the place of --strategy, --sensing and --penetration, for example zhao2025=0.3,yan2025=0.2 or
    passenger:zhao2025=0.5,truck:zhao2025/radar=0.2; KIND is a vehicle class or a vehicle type, all cars without it.
    Beside it, --set names the system, too: --set zhao2025.comfort_decel=5.
    """
    chosen = _scenario(scenario, sumocfg).varied(
        **variation, drivers=None if drivers is None else profile.load(drivers)
    )
    if equip is None:
        system = strategies.load("zhao2025" if strategy is None else strategy, parameters)
        carried = equipment(system, sensing=sensing, penetration=penetration)
    else:
        carried = equipment(
            strategy, sensing=sensing, penetration=penetration, equip=Equipment.parse(equip, parameters)
        )
    _check(carried, compare=compare, with_ceilings=with_ceilings)
    folder = None if out is None else new_folder(out).local
    console = Console(stderr=True)
    done: list[Results] = []
    with _interruptible() as stop:
        for each in (Equipment(), carried) if compare else (carried,):
            more = with_ceilings and not each.systems  # is to come before the run exists
            with _sumo_folder(folder, each.folder) as sumo_output, _progress(console, each.name, quiet) as progress:
                one = simulate(
                    chosen, equip=each, sumo_output=sumo_output, progress=progress, stop=stop,
                    out=None if more else out, **options,
                )  # fmt: skip
            if more:
                with _progress(console, "ceilings", quiet) as progress:
                    one = ceilings(chosen, one, beside=carried, progress=progress, stop=stop)
                if out is not None:
                    store.write(one, out)
            done.append(one)
            if one.runs["outcome"].iloc[0] != "completed":
                break
    if not quiet:
        data = analysis.load(out) if out is not None else analysis.Dataset.of(Results.joined(done))
        print_summary(analysis.summary(data), chosen.name)
        if compare and len(done) == 2:
            _print_pairs(data)
        if with_ceilings and len(data.ceilings):
            print_frame(analysis.ceiling_shares(data), "crashes of the baseline avoided by")
        if out is not None:
            click.echo(f"Tables in {out}: pandas.read_parquet('{out}/crashes'), or analysis.load('{out}').")
    step = float(done[-1].runs["step_length_s"].iloc[0])
    if step > _LONG_STEP:
        click.echo(f"aeb-sumo: note: an AEB that acts every {step:g} s only is not what it was published as", err=True)
    outcome, reason = done[-1].runs[["outcome", "reason"]].iloc[0]
    if outcome == "failed":
        raise InputError(f"{reason} (the tables hold what was simulated until then)")
    return 130 if stop() else 0  # also when it was the ceilings that were interrupted


def _check(carried: Equipment, *, compare: bool, with_ceilings: bool) -> None:
    """What is asked for has something to compare."""
    if compare and not carried.systems:
        raise InputError("--compare needs a --strategy other than none, which is what it compares with")
    if with_ceilings and carried.systems and not compare:
        raise InputError("--ceilings are those of the baseline: give --strategy none, or --compare")


def _print_pairs(data: analysis.Dataset) -> None:
    """What became of the crashes of the baseline, if both runs lasted as long."""
    try:
        print_pairs(analysis.pair_counts(data), "what became of the crashes of the baseline")
    except InputError as error:
        click.echo(f"aeb-sumo: note: the two runs are no pair: {error}", err=True)


def _scenario(name: str | None, sumocfg: Path | None) -> scenarios.Scenario:
    if (name is None) == (sumocfg is None):
        raise InputError(f"give one of SCENARIO ({', '.join(scenarios.names())}) and --sumocfg FILE")
    return scenarios.from_sumocfg(sumocfg) if sumocfg is not None else scenarios.load(str(name))


@contextmanager
def _sumo_folder(out: Path | None, name: str) -> Iterator[Path | None]:
    """The folder for SUMO's own output files; taken away again when nothing comes of the run."""
    if out is None:
        yield None
        return
    target = out / "sumo" / name
    made = [p for p in (target, out / "sumo", out) if not p.exists()]
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {target}: {error.strerror}") from None
    try:
        yield target
    except BaseException:
        if made:
            shutil.rmtree(made[-1], ignore_errors=True)
        raise
    for path in (target, out / "sumo"):
        if not any(path.iterdir()):
            path.rmdir()


@contextmanager
def _interruptible() -> Iterator[Callable[[], bool]]:
    """Ctrl-C ends the run after the current step; a second one ends the program."""
    asked = False

    def ask(number: int, frame: FrameType | None) -> None:  # noqa: ARG001
        nonlocal asked
        asked = True
        signal.signal(signal.SIGINT, before)

    before = signal.signal(signal.SIGINT, ask)
    try:
        yield lambda: asked
    finally:
        signal.signal(signal.SIGINT, before)


@cache
def _announce_compiling() -> None:
    announce(lambda: click.echo("aeb-sumo: compiling for this machine, once: about half a minute", err=True))


@contextmanager
def _progress(console: Console, name: str, quiet: bool) -> Iterator[Callable[[Step], None] | None]:
    if quiet or not console.is_terminal:
        yield None
        return
    columns = (
        TextColumn("{task.description:>10}"),
        BarColumn(),
        TextColumn("{task.fields[note]}"),
        TimeRemainingColumn(),
    )
    _announce_compiling()
    # No thread that refreshes: a world is forked with one thread only.
    with Progress(*columns, console=console, auto_refresh=False) as bar:
        task = bar.add_task(name, total=None, note="starting SUMO")
        drawn = 0.0

        def show(step: Step) -> None:
            nonlocal drawn
            now = time.monotonic()
            last = step.duration is not None and step.time >= step.duration
            if now - drawn < 0.1 and not last:
                return
            drawn = now
            span = f"{step.time:.0f} s" if step.duration is None else f"{step.time:.0f}/{step.duration:.0f} s"
            note = f"{span}  {step.vehicles} vehicles  {step.crashes} crashes  {step.interventions} interventions"
            bar.update(task, completed=step.time, total=step.duration, note=note, refresh=True)

        yield show
