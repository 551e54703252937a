"""`aeb-sumo drivers`."""

import click

from aeb_sumo.drivers import profile

__all__ = ["drivers"]


@click.command()
@click.argument("name", required=False)
def drivers(name: str | None) -> int:
    """Print the driver profile NAME, to copy and change, or the names of all."""
    if name is None:
        for each in profile.names():
            click.echo(f"{each:>14}  {profile.text(each).splitlines()[0].lstrip('# ')}")
    elif name.endswith(".toml"):  # a check of one's own
        profile.load(name)
        click.echo(f"{name} is a valid driver profile")
    else:
        click.echo(profile.text(name), nl=False)
    return 0
