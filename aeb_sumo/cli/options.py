"""Options that several commands share."""

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar

import click

from aeb_sumo.parameters import parse, read_file
from aeb_sumo.perception.suites import SUITES, suite

__all__ = ["system_options"]

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
