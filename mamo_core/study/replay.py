"""The independent check of a plan: through its file, in a model built for nothing else."""

from __future__ import annotations

import tempfile
from pathlib import Path

from mamo_core.build_context import PlanVerifier
from mamo_core.choices import choose
from mamo_core.compose import build_parts
from mamo_core.config import Located
from mamo_core.plan_file import PlanDocument, read_plan
from mamo_core.plugins import Registry
from mamo_core.recipes import load_recipe


def replay_failures(plan_text: str, registry: Registry) -> tuple[str, ...]:
    """What fails when a plan file is written, read back and replayed in a new model.

    The model is the recipe's engine, with the problem's own parameters.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plan.json"
        path.write_text(plan_text, encoding="utf-8")
        document = read_plan(path)
    return verifier_of(document, registry)(document.plan).failures


def verifier_of(document: PlanDocument, registry: Registry) -> PlanVerifier:
    """A verifier in a new model of the engine and the options that a plan was made with."""
    recipe = load_recipe(Located(dict(document.recipe), "plan.json: recipe"))
    choices = choose(recipe, document.problem, registry, ("constraint", "backend"))
    verifier: PlanVerifier = build_parts(choices, document.problem).part("verifier")
    return verifier
