"""``mamo study``: run, look at, report and export studies."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(help="Many problems with many planners.", no_args_is_help=True)

Database = Annotated[Path, typer.Argument(metavar="DB", help="Store of a study.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document.")]


class ExecutorName(StrEnum):
    """Where worker processes run."""

    LOCAL = "local"
    RAY = "ray"


@app.command()
def run(
    study: Annotated[Path, typer.Argument(metavar="STUDY.yaml", help="Study file.")],
    store: Annotated[
        Path | None, typer.Option(metavar="DB", help="Store (default: out/NAME.db).")
    ] = None,
    executor: Annotated[
        ExecutorName, typer.Option(help="Workers of this machine, or of a Ray cluster.")
    ] = ExecutorName.LOCAL,
    workers: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Worker processes (default: cores).")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change the study; may be repeated."),
    ] = None,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Also do again what crashed or timed out.")
    ] = False,
    any_code: Annotated[
        bool, typer.Option("--any-code", help="Rows of other code of mamo count as done.")
    ] = False,
    plans: Annotated[bool, typer.Option("--plans/--no-plans", help="Keep plans, too.")] = True,
    json: Json = False,
) -> None:
    """Do what is left of a study; the same command goes on after an interruption."""
    from mamo_core.cli.studying import run_run
    from mamo_core.study.run import StudyOrder

    order = StudyOrder(
        study=study,
        store=store,
        executor=executor.value,
        workers=workers,
        settings=tuple(settings or ()),
        retry_failed=retry_failed,
        any_code=any_code,
        plans=plans,
    )
    run_run(order, as_json=json)


@app.command()
def status(store: Database, json: Json = False) -> None:
    """Say how far a study is."""
    from mamo_core.cli.studying import run_status

    run_status(store, as_json=json)


@app.command()
def report(
    store: Database,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE", help="Write .md, .html or .json."),
    ] = None,
    against: Annotated[
        list[str] | None,
        typer.Option(
            metavar="RECIPE",
            help="Compare with this recipe, not the study's baseline; may be repeated.",
        ),
    ] = None,
    split_by: Annotated[
        str | None,
        typer.Option(
            metavar="RECIPE", help="Instead of the classes: did this recipe take --seconds or more?"
        ),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(metavar="S", min=0.0, help="CPU time for --split-by (default: 1)."),
    ] = None,
    page: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Write index.html with pictures and plans beside it."),
    ] = None,
    json: Json = False,
) -> None:
    """Tables of a study: success, seconds, comparisons, causes."""
    from mamo_core.cli.studying import run_report

    run_report(store, output, page, tuple(against or ()), (split_by, seconds), as_json=json)


@app.command()
def export(
    store: Database,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="FILE", help="Write .csv, .parquet or .log (OMPL's format)."
        ),
    ] = None,
    plans: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Write the plans as plan files.")
    ] = None,
) -> None:
    """Write the rows of a study for other programs."""
    from mamo_core.cli.studying import run_export

    run_export(store, output, plans)
