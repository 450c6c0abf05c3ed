"""The tasks of a study: each problem with each recipe, engine and seed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from mamo_core.study.definition import Study, Variant
from mamo_core.study.jobs import Call, Job
from mamo_core.study.problems import StudyProblem, content_hash


@dataclass(frozen=True)
class Task:
    """One line of a study.

    ``key``: hash of all that a row depends on; ``subject``: the same but for the code.
    ``problem``: hash of its content. ``budget``: CPU s.
    """

    key: str
    subject: str
    set_name: str
    problem_id: str
    problem: str
    recipe: str
    engine: str
    seed: int
    budget: float


def make_tasks(
    study: Study, problems: Iterable[StudyProblem], code: str
) -> Iterator[tuple[Task, StudyProblem, Variant]]:
    """All tasks; those of one problem follow each other, so that half a study compares, too."""
    for problem in problems:
        for seed in study.seeds:
            for variant in study.variants:
                yield _task(study, problem, variant, seed, code), problem, variant


def _task(study: Study, problem: StudyProblem, variant: Variant, seed: int, code: str) -> Task:
    identity = {
        "problem": problem.hash,
        "recipe": variant.loaded.data,
        "engine": variant.engine,
        "seed": seed,
        "budget": float(study.budget),
    }
    return Task(
        key=content_hash({**identity, "code": code}),
        subject=content_hash(identity),
        set_name=problem.set_name,
        problem_id=problem.id,
        problem=problem.hash,
        recipe=variant.recipe,
        engine=variant.engine,
        seed=seed,
        budget=float(study.budget),
    )


@dataclass(frozen=True)
class Work:
    """The functions that workers call, by name; tests put others in their place."""

    ready: str = "mamo_core.study.solving:get_ready"
    ready_to_classify: str = "mamo_core.study.solving:get_ready_to_classify"
    solve: str = "mamo_core.study.solving:solve"
    classify: str = "mamo_core.study.solving:classify"
    generate: str = "mamo_core.study.solving:generate"
    generate_workspace: str = "mamo_core.study.solving:generate_workspace"


def solve_job(
    task: Task, problem: StudyProblem, variant: Variant, deadline: float, code: str, work: Work
) -> Job:
    """The job that does a task."""
    recipe = variant.loaded.data
    robots = [problem.document["robot"]["name"]]
    return Job(
        key=task.key,
        work=Call(
            work.solve,
            {
                "problem": problem.document,
                "recipe": recipe,
                "seed": task.seed,
                "budget": task.budget,
            },
        ),
        deadline=deadline,
        ready=Call(work.ready, {"recipe": recipe, "robots": robots, "code": code}),
    )
