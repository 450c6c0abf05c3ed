"""``mamo plan``: find, verify and write a plan."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def plan(
    problem: Annotated[str, typer.Argument(metavar="PROBLEM[#id]", help="Problem file.")],
    planner: Annotated[
        str, typer.Option(metavar="NAME|FILE", help="Recipe: one of ours, or a YAML file.")
    ] = "default",
    backend: Annotated[
        str | None, typer.Option(metavar="NAME", help="Physics engine, instead of the recipe's.")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change the recipe; may be repeated."),
    ] = None,
    budget: Annotated[
        float, typer.Option(metavar="S", min=0.0, help="CPU seconds for planning.")
    ] = 60.0,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Seed of all random numbers.")] = 0,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write the plan here.")
    ] = None,
    png: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a top-down picture here.")
    ] = None,
    graph: Annotated[
        Path | None,
        typer.Option(metavar="FILE.svg", help="Draw the rearrangements that were searched."),
    ] = None,
    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document instead of tables.")
    ] = False,
) -> None:
    """Find, verify and write a plan that retrieves the target, or reaches for it."""
    from mamo_core.cli.planning import PlanOrder, run_plan

    order = PlanOrder(
        problem=problem,
        planner=planner,
        backend=backend,
        settings=tuple(settings or ()),
        budget=budget,
        seed=seed,
        output=output,
        png=png,
        graph=graph,
    )
    raise typer.Exit(run_plan(order, as_json=json))
