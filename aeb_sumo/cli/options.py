"""Options that several commands share."""

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar

import click

from aeb_sumo import results as store
from aeb_sumo.errors import InputError
from aeb_sumo.parameters import parse, read_file
from aeb_sumo.perception.suites import SUITES, suite
from aeb_sumo.results.place import Place

__all__ = ["new_folder", "scenario_options", "system_options"]

C = TypeVar("C", bound=Callable[..., Any])


def system_options(command: C) -> C:
    """Adds `--sensing`, `--params` and `--set`; the command gets `sensing` (checked) and `parameters` (merged)."""

    @click.option("--sensing", help=f"Sensors: {', '.join(SUITES)}. [default: the system's own]")
    @click.option("--params", type=click.Path(path_type=Path), help="TOML file with parameters of the AEB; --set wins.")
    @click.option(
        "--set", "assignments", multiple=True, metavar="NAME=VALUE", help="A parameter of the AEB; repeatable."
    )
    @wraps(command)
    def with_system(
        *args: Any, sensing: str | None, params: Path | None, assignments: tuple[str, ...], **options: Any
    ) -> Any:
        if sensing is not None:
            suite(sensing)
        parameters = {**({} if params is None else read_file(params)), **parse(assignments)}
        return command(*args, sensing=sensing, parameters=parameters, **options)

    return with_system  # type: ignore[return-value]


def scenario_options(command: C) -> C:
    """Adds `--demand`, `--ebike-share`, `--weather` and `--mu`; the command gets `variation`, for `Scenario.varied`."""

    @click.option("--demand", type=float, help="Factor on all flows. [default: 1]")
    @click.option("--ebike-share", type=float, help="Share of e-bikes, 0..1. [default: the scenario's]")
    @click.option("--weather", help="dry or wet: the friction of the road. [default: the scenario's]")
    @click.option("--mu", type=float, help="Friction coefficient of the road; wins over --weather.")
    @wraps(command)
    def with_variation(
        *args: Any,
        demand: float | None,
        ebike_share: float | None,
        weather: str | None,
        mu: float | None,
        **options: Any,
    ) -> Any:
        variation = {"demand": demand, "ebike_share": ebike_share, "weather": weather, "mu": mu}
        return command(*args, variation=variation, **options)

    return with_variation  # type: ignore[return-value]


def new_folder(name: str) -> Place:
    """The place for the tables, a local folder or an fsspec URL, which must not hold any yet."""
    if not name.strip():
        raise InputError("--out is empty; name a new or empty folder")
    place = Place.of(name)
    if place.local is not None and place.local.exists() and not place.local.is_dir():
        raise InputError(f"--out {name} is a file, not a folder")
    if store.holds_results(name):
        raise InputError(f"--out {name} already holds results; name a new or empty folder")
    return place
