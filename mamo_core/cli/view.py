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
    still: Annotated[
        Path | None, typer.Option(metavar="FILE.png", help="Before and after, in 3-D.")
    ] = None,
    mp4: Annotated[Path | None, typer.Option(metavar="FILE", help="The replay as a video.")] = None,
    gif: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The replay as a moving GIF.")
    ] = None,
    fps: Annotated[
        float | None,
        typer.Option(
            metavar="N", min=1.0, max=50.0, help="Pictures a second (default: mp4 20, gif 10)."
        ),
    ] = None,
    speed: Annotated[
        float, typer.Option(metavar="N", min=0.1, max=20.0, help="2 plays twice as fast.")
    ] = 1.0,
    size: Annotated[
        str | None,
        typer.Option(
            metavar="WxH", help="Pixels (default: mp4 640x480, gif 480x360, still 2 of 800x600)."
        ),
    ] = None,
    renderer: Annotated[
        str, typer.Option(metavar="NAME", help="What draws in 3-D: see 'mamo plugins list'.")
    ] = "mujoco",
    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document instead of text.")
    ] = False,
) -> None:
    """Execute a plan once, record it, and show it as pictures or replays.

    A recording is shown without any engine. Several engines are shown together.
    """
    from mamo_core.cli.view_order import ViewOrder
    from mamo_core.cli.viewing import run_view

    order = ViewOrder(
        subject=subject,
        backends=None if backends is None else tuple(backends.split(",")),
        output=output,
        png=png,
        html=html,
        live=live,
        port=port,
        still=still,
        mp4=mp4,
        gif=gif,
        fps=fps,
        speed=speed,
        size=size,
        renderer=renderer,
    )
    raise typer.Exit(run_view(order, as_json=json))
