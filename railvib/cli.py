"""The program `railvib`: a group whose sub-commands come from entry points.

Every package of the distribution brings its own sub-commands, so that none imports another for their sake. A
command is loaded when it is asked for: `railvib library` does not import the engine, nor `run` the library
before the workers are on their way.
"""

import errno
import os
from importlib import metadata
from typing import Any

import click

from railvib import signals
from railvib.errors import InputError, printable

ENTRY_POINTS = "railvib.commands"


class RefusedRequest(click.ClickException):
    """A wrong request: one line on standard error, exit code 2."""

    exit_code: int = 2  # type: ignore[misc]

    def format_message(self) -> str:
        """Return the message in one line, without what would steer a terminal."""
        return printable(self.message).replace("\n", "\\n")


class UnusablePlace(RefusedRequest):
    """A file, a folder or a means of this machine that cannot be used: exit code 2, or 1 if it is full."""

    def __init__(self, error: OSError) -> None:
        reason = error.strerror or f"{type(error).__name__}: {error}"
        names = [os.fsdecode(name) for name in (error.filename, error.filename2) if name is not None]
        super().__init__(f"{' and '.join(names)}: {reason}" if names else reason)
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            self.exit_code = 1


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
            with signals.raise_interrupts():
                return super().invoke(ctx)
        except (KeyboardInterrupt, Exception) as error:
            if isinstance(error, KeyboardInterrupt) or signals.end_requested():
                click.echo("interrupted", err=True)
                ctx.exit(signals.INTERRUPTED)
            if isinstance(error, InputError):
                raise RefusedRequest(str(error)) from error
            if isinstance(error, OSError) and error.errno != errno.EPIPE:  # which means that nobody reads on
                raise UnusablePlace(error) from error
            raise


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="railvib")
def main() -> None:
    """Predict ground-borne vibration from railway trains, and compare ways of computing it."""
