"""``mamo schema``: JSON schemas of our files, for editors and other programs."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Any

import typer


class Kind(StrEnum):
    """The kinds of files."""

    RECIPE = "recipe"
    PROBLEM = "problem"
    PLAN = "plan"
    STUDY = "study"


def schema(
    kind: Annotated[Kind, typer.Argument(help="Which file the schema is for.")],
) -> None:
    """Print the JSON schema of a kind of file."""
    import json

    typer.echo(json.dumps(_schema(kind), indent=2))


def _schema(kind: Kind) -> dict[str, Any]:
    if kind is Kind.PROBLEM:
        from mamo_core.problems.schema import problem_schema

        return problem_schema()
    if kind is Kind.PLAN:
        from mamo_core.plan_schema import PlanFile

        return PlanFile.model_json_schema()
    if kind is Kind.STUDY:
        from mamo_core.study.schema import StudyFile

        return StudyFile.model_json_schema()
    from mamo_core.recipes import Recipe

    return Recipe.model_json_schema()
