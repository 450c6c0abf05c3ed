"""The command ``mamo``: what it does stands in the modules beside this one.

Nothing slow is imported here, so that ``mamo --help`` answers at once.
"""

from __future__ import annotations

import os
import signal
import sys
import traceback
from collections.abc import Sequence
from importlib.metadata import version
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup

from mamo_core.cli import compare, plan, plugins, problem, schema, study, verify, view, warmup
from mamo_core.errors import MamoError

INTERNAL_ERROR = 1
INTERRUPTED = 130
TRACEBACK = "MAMO_TRACEBACK"


class _Commands(TyperGroup):
    """Ours, and those of plugins, which are looked for only under a name that none of ours has."""

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # which click is typer's affair
        found = super().get_command(ctx, cmd_name)
        if found is not None:
            return found
        from mamo_core.cli.workbench import plugin_command

        return plugin_command(cmd_name)


app = typer.Typer(
    name="mamo",
    cls=_Commands,
    help="Plan how a robot arm retrieves an object from clutter, or reaches for it, by moving "
    "others out of the way.",
    epilog="Plugins may add commands: see the role 'command' of 'mamo plugins list'. "
    "Exit codes: 0 done, 1 internal error, 2 wrong usage or input, 3 no plan within the "
    "budget, 4 verification failed, 5 backend or plugin missing, 6 worker crashed, "
    "130 interrupted.",
    no_args_is_help=True,
    rich_markup_mode=None,  # rich is slow to import, and plain help can be piped
    pretty_exceptions_enable=False,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("plan")(plan.plan)
app.command("verify")(verify.verify)
app.command("view")(view.view)
app.command("compare")(compare.compare)
app.add_typer(problem.app, name="problem")
app.add_typer(study.app, name="study")
app.add_typer(plugins.app, name="plugins")
app.command("schema")(schema.schema)
app.command("warmup")(warmup.warmup)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run a command line and exit with its code; only internal errors show a traceback."""
    signal.signal(signal.SIGINT, _interrupted)
    try:
        app(args=arguments, prog_name="mamo")
    except MamoError as error:
        _tell(f"error: {error}")
        sys.exit(error.exit_code)
    except Exception as error:
        _tell_internal(error)
        sys.exit(INTERNAL_ERROR)
    sys.exit(0)


@app.callback(invoke_without_command=True)
def _root(
    show_version: bool = typer.Option(False, "--version", help="Print the version and exit."),
) -> None:
    if show_version:
        typer.echo(f"mamo {version('mamo')}")
        raise typer.Exit


def _interrupted(number: int, frame: Any) -> NoReturn:
    """End by SystemExit, which runs all clean-up and which no version of click replaces."""
    _tell("interrupted")
    sys.exit(INTERRUPTED)


def _tell_internal(error: Exception) -> None:
    if os.environ.get(TRACEBACK):
        traceback.print_exception(error)
    text = " ".join(str(error).split())
    _tell(f"internal error: {type(error).__name__}: {text} (for details set {TRACEBACK}=1)")


def _tell(text: str) -> None:
    print(text, file=sys.stderr)
