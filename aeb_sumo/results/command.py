"""The command line that repeats a run, from its row in `runs`."""

import re
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

__all__ = ["arguments", "shell"]

_BETWEEN = re.compile(r" (?=[\w.]+=)")  # the spaces between parameters, not those within a value
_TOML = {"True": "true", "False": "false"}


def arguments(run: Mapping[str, Any], *, seed: bool = True) -> list[str]:
    """Arguments of `aeb-sumo` that simulate again what a row of `runs` is of, without `--out`.

    Demand, share of e-bikes, weather, friction and drivers are named only where the run had been told of them, which
    its id shows: the scenario's own drivers need not have a name that leads back to them.

    Args:
        run: the row, columns as in `TABLES["runs"]`.
        seed: whether to name the seed.

    Returns:
        The words, beginning with `run`. They repeat a run that was completed; one that was interrupted or failed, until
        where it got.
    """
    scenario = str(run["scenario"])
    words = ["run", *(["--sumocfg", scenario] if _is_file(scenario) else [scenario])]
    words += [*_equipment(run), *_variation(run)]
    if seed:
        words += ["--seed", str(int(run["seed"]))]
    # Times are sums of steps, whose last digits mean nothing.
    duration, step = (f"{t:.12g}" for t in (run["end_s"] - run["begin_s"], run["step_length_s"]))
    return [*words, "--duration", duration, "--step-length", step, "--blockage", _number(run["blockage_s"])]


def shell(words: list[str]) -> str:
    """One line for a shell."""
    return shlex.join(["aeb-sumo", *words])


def _is_file(scenario: str) -> bool:
    """A .sumocfg, as its path was given; the scenarios' own names have neither folder nor ending."""
    return len(Path(scenario).parts) > 1 or bool(Path(scenario).suffix)


def _equipment(run: Mapping[str, Any]) -> list[str]:
    strategy = str(run["strategy"])
    if strategy == "none":
        return ["--strategy", "none"]
    if "=" in strategy:
        words = ["--equip", strategy]
    else:
        words = ["--strategy", strategy, "--sensing", str(run["sensing"]), "--penetration", _number(run["penetration"])]
    for part in _BETWEEN.split(str(run["parameters"])) if run["parameters"] else ():
        name, _, value = part.partition("=")
        words += ["--set", f"{name}={_TOML.get(value, value)}"]
    return words


def _variation(run: Mapping[str, Any]) -> list[str]:
    # `Scenario.variation` stands between the scenario's name and the equipment's.
    told = f"-{str(run['run_id']).removeprefix(Path(str(run['scenario'])).stem + '-')}"
    words = []
    if demand := re.match(r"-demand(\d[\d.]*(?:e[+-]\d+)?)-", told):
        # The id has six digits, the column all; the column has the configuration's own scale in it, too.
        same = f"{run['demand']:g}" == demand[1]
        words += ["--demand", _number(run["demand"]) if same else demand[1]]
    for option, column, tag in (
        ("--ebike-share", "ebike_share", "ebikes{:g}"),
        ("--weather", "weather", "{}"),
        ("--mu", "mu", "mu{:g}"),
    ):
        value = run[column]
        if not pd.isna(value) and value != "" and f"-{tag.format(value)}-" in told:
            words += [option, value if isinstance(value, str) else _number(value)]
    drivers = str(run["drivers"])
    if drivers and f"-{Path(drivers).stem}-" in told:
        words += ["--drivers", drivers]
    return words


def _number(value: float) -> str:
    """As short as it reads back the same."""
    return repr(float(value)).removesuffix(".0")
