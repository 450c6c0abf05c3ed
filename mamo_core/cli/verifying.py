"""The work behind ``mamo verify``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from mamo_core.choices import choose
from mamo_core.cli.output import print_json, progress, warn, warn_of_broken_plugins
from mamo_core.cli.plan_report import DONE, NOT_VERIFIED, WORKER_CRASHED
from mamo_core.compose import build_parts
from mamo_core.config import Located
from mamo_core.plan_file import PlanDocument, in_problem, package_versions, read_plan
from mamo_core.plugins import discover
from mamo_core.problems import load_problem
from mamo_core.recipe_sets import override
from mamo_core.recipes import LoadedRecipe, load_recipe

if TYPE_CHECKING:
    from mamo_core.verify import VerifyReport


def run_verify(
    path: Path, backend: str | None, problem: str | None = None, *, as_json: bool
) -> int:
    """Replay, check and report; the exit code.

    Raises:
        InputError: a file that cannot be read, or a ``problem`` of which the plan does not speak.
    """
    document = read_plan(path)
    if problem is not None:
        document = in_problem(document, load_problem(problem))
    _warn_of_other_versions(document)
    recipe = recipe_of(document, str(path), backend)
    registry = discover()
    warn_of_broken_plugins(registry)
    with progress() as tell:
        engine = recipe.recipe.backend.name
        others = () if backend is not None else ("accept_in",)
        tell(f"replaying {document.problem.name!r} with backend {engine!r}")
        choices = choose(recipe, document.problem, registry, ("constraint", "backend", *others))
        report = build_parts(choices, document.problem).part("verifier")(document.plan)
    world = problem if problem is not None else OWN_WORLD
    _print(path, document, engine, world, report, as_json=as_json)
    return WORKER_CRASHED if report.lost else DONE if report.ok else NOT_VERIFIED


OWN_WORLD = "the plan file itself"


def recipe_of(document: PlanDocument, path: str, backend: str | None) -> LoadedRecipe:
    """The recipe that stands in a plan file, with another engine if one is given."""
    located = Located(dict(document.recipe), f"{path}: recipe")
    if backend is not None:
        located = override(located, ["backend"], backend, "--backend")
    return load_recipe(located)


def _warn_of_other_versions(document: PlanDocument) -> None:
    """Another engine version may move objects otherwise, so a failure may come from that."""
    installed = package_versions()
    for package, version in sorted(document.versions.items()):
        if installed.get(package) != version:
            here = installed.get(package, "none")
            warn(f"the plan was made with {package} {version}, installed is {here}")


def _print(
    path: Path,
    document: PlanDocument,
    engine: str,
    world: str,
    report: VerifyReport,
    *,
    as_json: bool,
) -> None:
    if as_json:
        result = {
            "plan_file": str(path),
            "problem": document.problem.name,
            "backend": engine,
            "world": world,
            "verified": report.ok,
            "failures": list(report.failures),
            "unasked": list(report.unasked),
        }
        print_json("verify", result)
        return
    verdict = "verified" if report.ok else "FAILED"
    lines = [
        f"{path}: {verdict} with {engine}, in the world of {world}",
        *(f"  {text}" for text in report.failures),
        *(f"  not asked: {text}" for text in report.unasked),
    ]
    sys.stdout.write("\n".join(lines) + "\n")
