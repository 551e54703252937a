"""`aeb-sumo intersection`."""

from pathlib import Path

import click

from aeb_sumo.errors import InputError
from aeb_sumo.parameters import parse, read_file
from aeb_sumo.scenarios.own_intersection import from_parameters, write

__all__ = ["intersection"]


@click.command()
@click.argument("file", type=click.Path(path_type=Path), required=False)
@click.option(
    "--set", "assignments", multiple=True, metavar="NAME=VALUE", help="A parameter; repeatable; wins over FILE."
)
@click.option("--out", required=True, help="New or empty folder for net, buildings, traffic and configuration.")
def intersection(file: Path | None, assignments: tuple[str, ...], out: str) -> int:
    """Build an intersection from the parameters in FILE.toml; what is not stated is as at W0.

    For example lanes=2, median=4.6, signal=false, arms="nsw"; those of the traffic begin with demand, for example
    demand.flow=900. Run it with aeb-sumo run --sumocfg.
    """
    if not out.strip():
        raise InputError("--out is empty; name a new or empty folder")
    it, demand = from_parameters({**({} if file is None else read_file(file)), **parse(assignments)})
    configuration = write(it, demand, Path(out))
    click.echo(
        f"offset {it.offset:.2f} m: path of a car that turns left to that of the oncoming rider; "
        f"stop lines {it.stop:.2f} m from the centre.\nRun it: aeb-sumo run --sumocfg {configuration} --compare"
    )
    return 0
