"""``mamo verify``: replay a plan file, with nothing but what stands in it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def verify(
    plan: Annotated[Path, typer.Argument(metavar="PLAN", help="Plan file.")],
    backend: Annotated[
        str | None, typer.Option(metavar="NAME", help="Physics engine, instead of the plan's.")
    ] = None,
    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document instead of text.")
    ] = False,
) -> None:
    """Replay a plan file in simulation and check every claim.

    The exit code is 4 if one does not hold.
    """
    from mamo_core.cli.verifying import run_verify

    raise typer.Exit(run_verify(plan, backend, as_json=json))
