"""`aeb-sumo replay`."""

from pathlib import Path

import click

from aeb_sumo.errors import InputError
from aeb_sumo.replay import film, find, page

__all__ = ["replay"]


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.argument("event")
@click.option("--run", "run_id", help="Run of the event, where FOLDER holds several that have one of this number.")
@click.option("--before", type=float, default=5.0, show_default=True, help="Seconds before the event.")
@click.option("--after", type=float, default=6.0, show_default=True, help="Seconds after it, at least.")
@click.option("--out", type=click.Path(path_type=Path), help="The file. [default: replay-EVENT.html in FOLDER]")
def replay(folder: Path, event: str, run_id: str | None, before: float, after: float, out: Path | None) -> int:
    """Make EVENT of the results in FOLDER an HTML animation, beside the world in which it is otherwise.

    EVENT is crash:ID or intervention:ID, with the number that it has in its table. Its run is simulated again until the
    event is over. In the other world the intervention does not take place; where there was none, for a crash of the
    baseline, both vehicles have an AEB from 5 s before the crash on.
    """
    if out is not None and out.is_dir():
        raise InputError(f"--out {out} is a folder, not a file")
    if out is not None and not out.parent.is_dir():
        raise InputError(f"no folder {out.parent} to write {out.name} into")
    found = find(folder, event, run_id)
    name = "-".join(["replay", *([] if run_id is None else [run_id]), found.kind, str(found.number)])
    target = folder / f"{name}.html" if out is None else out
    click.echo(f"simulating {found.run['run_id']} again, until {found.end + after:.0f} s", err=True)
    html = page(film(found, before=before, after=after))
    try:
        target.write_text(html, encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot write {target}: {error.strerror}") from None
    click.echo(f"{target}: open it in a browser.")
    return 0
