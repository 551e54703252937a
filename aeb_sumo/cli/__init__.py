"""The `aeb-sumo` command: one module per subcommand."""

import sys
from importlib import import_module

import click

import aeb_sumo
from aeb_sumo.errors import InputError

__all__ = ["main"]

_MODULES = {
    "run": "run",
    "compare": "tables",
    "report": "report",
    "replay": "replay",
    "tables": "tables",
    "sweep": "sweep",
    "campaign": "campaign",
    "plan": "plan",
    "drivers": "drivers",
    "calibrate": "calibrate",
    "intersection": "intersection",
    "reproduce": "reproduce",
    "ncap": "ncap",
    "bench": "bench",
}
"""Subcommand -> module that has it."""


class _Commands(click.Group):
    """Imports a subcommand when it is asked for: each needs other libraries, and all together take seconds."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        return list(_MODULES)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        if cmd_name not in _MODULES:
            return None
        command = getattr(import_module(f"{__name__}.{_MODULES[cmd_name]}"), cmd_name)
        return command if isinstance(command, click.Command) else None


@click.group(cls=_Commands)
@click.version_option(aeb_sumo.__version__, prog_name="aeb-sumo")
def cli() -> None:
    """What an automatic emergency brake (AEB) does to real traffic."""


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
            message += f" There are: {', '.join(error.ctx.command.list_commands(error.ctx))}."
        _fail(message)
    except click.ClickException as error:
        _fail(error.format_message())
    except click.Abort:
        sys.exit(130)
    sys.exit(status if isinstance(status, int) else 0)


def _fail(message: str) -> None:
    click.echo(f"aeb-sumo: {' '.join(message.split())}", err=True)
    sys.exit(2)
