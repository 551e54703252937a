"""The `aeb-sumo` command: one module per subcommand."""

import sys
from importlib import import_module

import click

import aeb_sumo
from aeb_sumo.errors import InputError

__all__ = ["main"]

_COMMANDS = {
    "run": ("run", "Simulate one scenario with an AEB fleet."),
    "compare": ("tables", "Print the figures of one or two results folders."),
    "report": ("report", "Write the results as one HTML page."),
    "replay": ("replay", "Make one crash or intervention an animation."),
    "tables": ("tables", "Print what the columns of the tables mean."),
    "sweep": ("sweep", "Vary one parameter: interventions against crashes."),
    "campaign": ("campaign", "Execute many runs, and go on where that was ended."),
    "plan": ("plan", "Say beforehand what a campaign will cost and tell."),
    "drivers": ("drivers", "Print a driver profile, or which there are."),
    "calibrate": ("calibrate", "Hold the drivers on the highway against the evidence."),
    "intersection": ("intersection", "Build an intersection from parameters."),
    "reproduce": ("reproduce", "Run the published tests of the systems."),
    "ncap": ("ncap", "Test a system on the proving ground, with scores."),
    "bench": ("bench", "Measure what an AEB costs on top of SUMO alone."),
}
"""Subcommand -> module that has it, and what it does, in the list of all."""


class _Commands(click.Group):
    """Imports a subcommand when it is asked for: each needs other libraries, and all together take seconds."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        if cmd_name not in _COMMANDS:
            return None
        command = getattr(import_module(f"{__name__}.{_COMMANDS[cmd_name][0]}"), cmd_name)
        return command if isinstance(command, click.Command) else None

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        with formatter.section("Commands"):
            formatter.write_dl([(name, what) for name, (_, what) in _COMMANDS.items()])


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
