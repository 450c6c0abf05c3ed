"""``mamo view``: look at a plan."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def view(
    subject: Annotated[
        str, typer.Argument(metavar="PLAN|RECORDING", help="Plan file, or a recording (.npz).")
    ],
    backends: Annotated[
        str | None,
        typer.Option(metavar="A,B,...", help="Engines that execute the plan, instead of its own."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE.npz", help="Keep the recording.")
    ] = None,
    png: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Before and after, from above.")
    ] = None,
    html: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Replay for a browser, in one file.")
    ] = None,
    live: Annotated[
        bool, typer.Option("--live", help="Serve the replay to this machine until interrupted.")
    ] = False,
    port: Annotated[
        int | None,
        typer.Option(metavar="N", min=0, max=65535, help="Of --live; 0 is any free one.  [8080]"),
    ] = None,
    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document instead of text.")
    ] = False,
) -> None:
    """Execute a plan once, record it, and show it as pictures or replays.

    A recording is shown without any engine. Several engines are shown together.
    """
    from mamo_core.cli.viewing import ViewOrder, run_view

    engines = None if backends is None else tuple(backends.split(","))
    order = ViewOrder(
        subject=subject,
        backends=engines,
        output=output,
        png=png,
        html=html,
        live=live,
        port=port,
    )
    raise typer.Exit(run_view(order, as_json=json))
