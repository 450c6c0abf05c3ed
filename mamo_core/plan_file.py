"""Plan files: everything needed to rebuild, replay and check a plan, and nothing that varies
or that nobody could check.

The same problem, recipe and seed give the same bytes, so there are no times of day and no CPU
seconds in here. Floats are written with all their digits.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from mamo_core.atomic import atomic_path
from mamo_core.config import Located, load_file, load_text, validated
from mamo_core.errors import InputError
from mamo_core.plan_schema import (
    SCHEMA_VERSION,
    ActionDocument,
    MotionDocument,
    PlanFile,
    SegmentDocument,
)
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion, MotionSegment, Trajectory
from mamo_core.types.problem import Problem
from mamo_core.types.solution import Plan, SolutionStatus

MAX_BYTES = 256 * 1024 * 1024
VERSIONED = ("dartpy", "mamo", "mujoco", "numpy", "pin", "pybullet")


@dataclass(frozen=True, eq=False)
class PlanDocument:
    """A plan with the problem it solves and how it was made.

    ``recipe``: the recipe's data. ``versions``: of the packages that made it. ``margin``: share of
    the worlds in which it holds, by how far they are off (``mamo_core.margin``); empty where nobody
    measured it.
    """

    problem: Problem
    plan: Plan
    recipe: Mapping[str, Any]
    seed: int
    status: SolutionStatus = SolutionStatus.SOLVED
    margin: Mapping[str, float] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=lambda: package_versions())


def package_versions() -> dict[str, str]:
    """Versions of the packages a result depends on, of those that are installed."""
    found: dict[str, str] = {}
    for package in VERSIONED:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


def write_plan(path: str | Path, document: PlanDocument) -> None:
    """Write the document, complete or not at all.

    Raises:
        InputError: its folder is missing or cannot be written.
    """
    with atomic_path(path) as work:
        work.write_text(plan_text(document), encoding="utf-8")


def plan_text(document: PlanDocument) -> str:
    """The text of a plan file: JSON, keys sorted, one line for each thing at the top."""
    data = plan_data(document)
    lines = [f"{json.dumps(key)}: {_dumps(data[key])}" for key in sorted(data)]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def is_plan_file(path: str | Path) -> bool:
    """Whether it is a file with the marks of a plan, so that it should be read as one."""
    file = Path(path)
    if file.suffix != ".json" or not file.is_file():
        return False
    try:
        data = json.loads(file.read_bytes())
    except ValueError:
        return False
    return isinstance(data, dict) and {"recipe", "retrieval"} <= set(data)


def read_plan(path: str | Path) -> PlanDocument:
    """Read a plan file.

    Raises:
        InputError: missing, truncated, or not what a plan file holds.
    """
    return _read(load_file(path, max_bytes=MAX_BYTES), str(path))


def read_plan_text(text: str, source: str) -> PlanDocument:
    """What ``plan_text`` gave; ``source`` names it in errors.

    Raises:
        InputError: not what a plan file holds.
    """
    return _read(load_text(text, source, max_bytes=MAX_BYTES), source)


def _read(located: Located, source: str) -> PlanDocument:
    from mamo_core.problems.documents import problem_from_document

    version = located.data.get("schema_version") if isinstance(located.data, dict) else None
    if isinstance(version, int) and version < SCHEMA_VERSION:
        raise located.error(
            f"schema_version: {version}, expected {SCHEMA_VERSION}: it says too little of its "
            "trajectories and grasps to be verified, plan the problem again"
        )
    raw = validated(PlanFile, located)
    problem = problem_from_document(located.data["problem"], f"{source}: problem")
    try:
        plan = Plan(
            actions=tuple(_action(item) for item in raw.actions),
            retrieval=_motion(raw.retrieval),
        )
        _check_fits(plan, problem)
    except ValueError as error:
        raise located.error(str(error)) from None
    return PlanDocument(
        problem=problem,
        plan=plan,
        recipe=raw.recipe,
        seed=raw.seed,
        status=SolutionStatus(raw.status),
        margin=raw.margin,
        versions=raw.versions,
    )


def in_problem(document: PlanDocument, problem: Problem) -> PlanDocument:
    """The same plan for a problem that does not come from its file.

    Raises:
        InputError: the plan speaks of objects, or of joints, that the problem does not have.
    """
    try:
        _check_fits(document.plan, problem)
    except ValueError as error:
        raise InputError(f"problem {problem.name!r} does not fit the plan: {error}") from None
    return replace(document, problem=problem)


def plan_data(document: PlanDocument) -> dict[str, Any]:
    """The document as plain data."""
    from mamo_core.problems.documents import problem_document

    plan = document.plan
    return {
        "schema_version": SCHEMA_VERSION,
        "problem": problem_document(document.problem),
        "recipe": dict(document.recipe),
        "seed": document.seed,
        "status": str(document.status),
        "versions": dict(document.versions),
        "margin": dict(document.margin),
        "actions": [_action_data(action) for action in plan.actions],
        "retrieval": _motion_data(plan.retrieval),
    }


def _dumps(data: Any) -> str:
    return json.dumps(data, sort_keys=True, allow_nan=False, separators=(",", ":"))


def _action_data(action: RearrangementAction) -> dict[str, Any]:
    return {
        "kind": action.kind,
        "object": action.object_name,
        "path": action.path.tolist(),
        "motion": _motion_data(action.motion),
        "info": _plain(action.info),
    }


def _check_fits(plan: Plan, problem: Problem) -> None:
    """ValueError unless the plan speaks of the problem's robot and objects."""
    joints = problem.home.size
    names = [item.name for item in problem.scene.objects]
    unknown = {action.object_name for action in plan.actions} - set(names)
    for motion in plan.motions:
        for segment in motion.segments:
            columns = segment.trajectory.positions.shape[1]
            if columns != joints:
                raise ValueError(f"a trajectory of {columns} joints, the robot has {joints}")
            handled = (segment.held, segment.closes_on)
            unknown |= {name for name in handled if name is not None and name not in names}
    if unknown:
        raise ValueError(f"no objects {sorted(unknown)} in the problem (valid: {names})")


def _plain(value: Any) -> Any:
    """Numpy values as Python's own, so that any generator's ``info`` can be written."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def _motion_data(motion: Motion) -> dict[str, Any]:
    return {
        "opening": motion.opening,
        "segments": [_segment_data(segment) for segment in motion.segments],
    }


def _segment_data(segment: MotionSegment) -> dict[str, Any]:
    return {
        "kind": str(segment.kind),
        "times": segment.trajectory.times.tolist(),
        "positions": segment.trajectory.positions.tolist(),
        "velocities": segment.trajectory.velocities.tolist(),
        "opening": segment.opening,
        "held": segment.held,
        "contact_free": segment.contact_free,
        "settle": segment.settle,
        "closes_on": segment.closes_on,
    }


def _action(item: ActionDocument) -> RearrangementAction:
    path = _table(item.path, 2)
    return RearrangementAction(item.kind, item.object, _motion(item.motion), path, item.info)


def _motion(item: MotionDocument) -> Motion:
    return Motion(tuple(_segment(segment) for segment in item.segments), item.opening)


def _segment(item: SegmentDocument) -> MotionSegment:
    return MotionSegment(
        kind=item.kind,
        trajectory=Trajectory(
            np.array(item.times), _table(item.positions, None), _table(item.velocities, None)
        ),
        opening=item.opening,
        held=item.held,
        contact_free=item.contact_free,
        settle=item.settle,
        closes_on=item.closes_on,
    )


def _table(rows: Any, columns: int | None) -> Array:
    widths = {len(row) for row in rows}
    if len(widths) > 1 or (columns is not None and widths - {columns}):
        raise ValueError(f"rows of {sorted(widths)} numbers, expected rows of one length")
    return np.array(rows, dtype=np.float64).reshape(len(rows), columns or max(widths, default=0))
