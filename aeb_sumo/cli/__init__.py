"""The `aeb-sumo` command: one module per subcommand."""

import sys

import click

import aeb_sumo
from aeb_sumo.cli.calibrate import calibrate
from aeb_sumo.cli.drivers import drivers
from aeb_sumo.cli.intersection import intersection
from aeb_sumo.cli.ncap import ncap
from aeb_sumo.cli.replay import replay
from aeb_sumo.cli.report import report
from aeb_sumo.cli.reproduce import reproduce
from aeb_sumo.cli.run import run
from aeb_sumo.cli.sweep import sweep
from aeb_sumo.cli.tables import compare, tables
from aeb_sumo.errors import InputError

__all__ = ["main"]


@click.group()
@click.version_option(aeb_sumo.__version__, prog_name="aeb-sumo")
def cli() -> None:
    """What an automatic emergency brake (AEB) does to real traffic."""


for command in (run, compare, report, replay, tables, sweep, drivers, calibrate, intersection, reproduce, ncap):
    cli.add_command(command)


def main() -> None:
    """Run the command; bad input gives one line on stderr and exit status 2."""
    try:
        status = cli.main(args=sys.argv[1:] or ["--help"], standalone_mode=False)
    except InputError as error:
        _fail(str(error))
    except click.NoSuchOption as error:
        known = [o for p in (error.ctx.command.params if error.ctx else []) for o in p.opts if o.startswith("--")]
        _fail(f"no such option: {error.option_name}; there are: {', '.join(known)}")
    except click.UsageError as error:
        message = error.format_message()
        if error.ctx is not None and isinstance(error.ctx.command, click.Group) and "No such command" in message:
            message += f" There are: {', '.join(error.ctx.command.commands)}."
        _fail(message)
    except click.ClickException as error:
        _fail(error.format_message())
    except click.Abort:
        sys.exit(130)
    sys.exit(status if isinstance(status, int) else 0)


def _fail(message: str) -> None:
    click.echo(f"aeb-sumo: {' '.join(message.split())}", err=True)
    sys.exit(2)
