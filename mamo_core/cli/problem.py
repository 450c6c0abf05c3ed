"""``mamo problem``: make, convert and look at problems."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(help="Import, generate and show problems.", no_args_is_help=True)
generate_app = typer.Typer(help="Generate problems.", no_args_is_help=True)
app.add_typer(generate_app, name="generate")

Output = Annotated[
    Path,
    typer.Option(
        "-o", "--output", metavar="FILE", help=".json or .yaml for one, .jsonl[.gz] for a set."
    ),
]


class Level(StrEnum):
    """Easy, medium, hard: 1, 2, more than 2 movables in the initial NGR."""

    EASY = "easy"
    MEDIUM = "medium"
    HARD = "hard"


@app.command("import")
def import_(
    source: Annotated[Path, typer.Argument(metavar="SRC", help="The file to convert.")],
    output: Output,
) -> None:
    """Convert published scenes (or problems of ours) to problem files."""
    from mamo_core.cli.problem_files import run_import

    run_import(source, output)


Seed = Annotated[int, typer.Option(metavar="N", min=0, help="Seed of the first problem.")]
Count = Annotated[int, typer.Option(metavar="K", min=1, help="Problems to make, one seed each.")]
Movables = Annotated[int, typer.Option(metavar="N", min=0, help="Number of movable objects.")]
Immovables = Annotated[
    int, typer.Option(metavar="N", min=1, help="Number of immovable objects with the target.")
]


@generate_app.command("shelf")
def shelf(
    output: Output,
    level: Annotated[
        Level | None, typer.Option(help="How many movables are in the way: 1, 2, more.")
    ] = None,
    movables: Annotated[
        int, typer.Option(metavar="N", min=1, help="Number of movable objects.")
    ] = 10,
    seed: Seed = 0,
    count: Count = 1,
) -> None:
    """A shelf with movables, immovables and a target, distributed as in the thesis."""
    from mamo_core.cli.generating import run_shelf

    run_shelf(
        level=level.value if level is not None else None,
        movables=movables,
        seed=seed,
        count=count,
        output=output,
    )


@generate_app.command("tabletop")
def tabletop(
    output: Output,
    movables: Movables = 6,
    immovables: Immovables = 6,
    seed: Seed = 0,
    count: Count = 1,
) -> None:
    """A reach for one of the YCB objects on a table, as in chapter 3 of the thesis."""
    from mamo_core.cli.generating import run_workspace

    run_workspace(
        "tabletop", movables=movables, immovables=immovables, seed=seed, count=count, output=output
    )


@generate_app.command("refrigerator")
def refrigerator(
    output: Output,
    movables: Movables = 3,
    immovables: Immovables = 2,
    seed: Seed = 0,
    count: Count = 1,
) -> None:
    """A reach for one of the YCB objects in a refrigerator, as in chapter 3 of the thesis."""
    from mamo_core.cli.generating import run_workspace

    run_workspace(
        "refrigerator",
        movables=movables,
        immovables=immovables,
        seed=seed,
        count=count,
        output=output,
    )


@app.command()
def show(
    problem: Annotated[str, typer.Argument(metavar="PROBLEM[#id]", help="Problem file.")],
    png: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a top-down picture here.")
    ] = None,
    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document instead of a table.")
    ] = False,
) -> None:
    """List what is in a problem."""
    from mamo_core.cli.problem_files import run_show

    run_show(problem, png, as_json=json)
