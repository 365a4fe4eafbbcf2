"""The program `railvib`: a group whose sub-commands come from entry points.

Every package of the distribution brings its own sub-commands, so that none imports another for their sake. A
command is loaded when it is asked for: `railvib library` does not import the engine, nor `run` the library
before the workers are on their way.
"""

from importlib import metadata
from typing import Any

import click

from railvib.errors import InputError

ENTRY_POINTS = "railvib.commands"


class RefusedRequest(click.ClickException):
    """A wrong request: one line on standard error, exit code 2."""

    exit_code = 2


class Commands(click.Group):
    """A group that finds its sub-commands among the entry points and turns refusals into exit code 2."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all sub-commands without importing any."""
        return sorted(metadata.entry_points(group=ENTRY_POINTS).names)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return a sub-command."""
        for point in metadata.entry_points(group=ENTRY_POINTS, name=cmd_name):
            command: click.Command = point.load()
            return command
        return None

    def invoke(self, ctx: click.Context) -> Any:
        """Run a sub-command."""
        try:
            return super().invoke(ctx)
        except InputError as error:
            raise RefusedRequest(str(error)) from error


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="railvib")
def main() -> None:
    """Predict ground-borne vibration from railway trains, and compare ways of computing it."""
