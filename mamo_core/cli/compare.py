"""``mamo compare``: the same plans in several engines."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def compare(
    subjects: Annotated[
        list[str], typer.Argument(metavar="PLAN|PROBLEM[#id]...", help="Plan or problem files.")
    ],
    backends: Annotated[
        str, typer.Option(metavar="A,B,...", help="Physics engines, two or more.")
    ] = "mujoco,pybullet,dart",
    planner: Annotated[
        str, typer.Option(metavar="NAME|FILE", help="Recipe with which problems are planned.")
    ] = "default",
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change the recipe; may be repeated."),
    ] = None,
    budget: Annotated[
        float, typer.Option(metavar="S", min=0.0, help="CPU seconds for planning, each.")
    ] = 60.0,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Seed of all random numbers.")] = 0,
    samples: Annotated[
        int,
        typer.Option(metavar="N", min=0, help="Shifted executions for an engine's chaos floor."),
    ] = 3,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write a JSON report.")
    ] = None,
    png: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the first plan in all engines.")
    ] = None,
    trace: Annotated[
        Path | None,
        typer.Option(metavar="FILE.npz", help="Record the first plan in all engines."),
    ] = None,
    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document instead of tables.")
    ] = False,
) -> None:
    """Execute plans in several engines and say where these part.

    A plan file is executed in every engine; a problem is first planned with each of them.
    """
    from mamo_core.cli.comparing import CompareOrder, run_compare

    order = CompareOrder(
        subjects=tuple(subjects),
        backends=tuple(backends.split(",")),
        planner=planner,
        settings=tuple(settings or ()),
        budget=budget,
        seed=seed,
        samples=samples,
        output=output,
        png=png,
        trace=trace,
    )
    raise typer.Exit(run_compare(order, as_json=json))
