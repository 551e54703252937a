"""`aeb-sumo report`."""

from pathlib import Path

import click

import analysis
from aeb_sumo import scenarios
from aeb_sumo.errors import InputError
from aeb_sumo.results.place import Place
from aeb_sumo.world.sumocfg import read
from analysis.report import render

__all__ = ["report"]


@click.command()
@click.argument("folder")
@click.option("--out", type=click.Path(path_type=Path), help="The file to write. [default: report.html in FOLDER]")
@click.option("--title", default="", help="Of the page. [default: systems and scenarios]")
def report(folder: str, out: Path | None, title: str) -> int:
    """Write one self-contained HTML page about the results in FOLDER, or at an fsspec URL."""
    local = Place.of(folder).local
    if local is not None and not local.is_dir():
        raise InputError(f"no folder {folder}: name a folder with results, as `aeb-sumo run --out` makes them")
    target = out or (local and local / "report.html")
    if target is None:
        raise InputError(f"--out is missing: name a file for the report about {folder}")
    if target.is_dir() or not target.parent.is_dir():
        raise InputError(f"--out {target}: name a file in an existing folder")
    data = analysis.load(folder)
    page = render(data, networks=_networks(sorted(data.runs["scenario"].unique())), title=title)
    try:
        target.write_text(page, encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot write {target}: {error.strerror}") from None
    click.echo(target)
    return 0


def _networks(names: list[str]) -> dict[str, Path]:
    """The road network of every scenario whose network is still where it was."""
    found = {name: _network(name) for name in names}
    return {name: path for name, path in found.items() if path is not None and path.is_file()}


def _network(name: str) -> Path | None:
    try:
        if name in scenarios.names():
            options = scenarios.load(name).options
            return Path(options[options.index("--net-file") + 1])
        config = read(name)
        return config.path.parent / config.options["net-file"]
    except (InputError, KeyError, ValueError):
        return None
