"""``mamo verify``: replay a plan file, in the world that it holds or in one of the user's."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def verify(
    plan: Annotated[Path, typer.Argument(metavar="PLAN", help="Plan file.")],
    backend: Annotated[
        str | None, typer.Option(metavar="NAME", help="Physics engine, instead of the plan's.")
    ] = None,
    problem: Annotated[
        str | None,
        typer.Option(
            metavar="PROBLEM",
            help="The problem that the plan is to solve, instead of the one in its file.",
        ),
    ] = None,
    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document instead of text.")
    ] = False,
) -> None:
    """Replay a plan file in simulation and check every claim.

    A plan file holds the world it was made for. With --problem the world is yours: the plan must
    hold there. The exit code is 4 if it does not.
    """
    from mamo_core.cli.verifying import run_verify

    raise typer.Exit(run_verify(plan, backend, problem, as_json=json))
