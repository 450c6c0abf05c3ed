"""From a recipe and a problem to parts that know each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from mamo_core.build_context import BuildContext, EngineFor, PlanVerifier
from mamo_core.choices import (
    BUILD_ORDER,
    Choice,
    changed,
    check_requirements,
    choose,
    constraint_choices,
)
from mamo_core.errors import InputError, PluginError
from mamo_core.hookspecs import Component, Options
from mamo_core.interfaces.search_strategy import ProgressCallback, SearchStrategy
from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.plugins import Registry
from mamo_core.recipes import LoadedRecipe
from mamo_core.robots.model import ArmModel
from mamo_core.types.problem import Problem
from mamo_core.types.solution import Budget, Plan, Solution, Statistics
from mamo_core.verdict import VerifiersEngines, make_verifier

if TYPE_CHECKING:
    from mamo_core.verify import VerifyReport


_SLACK = 1e-6  # rad; files may hold rounded joint positions
_SEVERAL = {"constraint": "constraints", "action": "actions"}


@dataclass(frozen=True, eq=False)
class Planner:
    """A recipe made for one problem."""

    recipe: LoadedRecipe
    context: BuildContext
    search: SearchStrategy

    def solve(
        self,
        budget_seconds: float = float("inf"),
        seed: int = 0,
        progress: ProgressCallback = lambda text: None,
    ) -> Solution:
        """Search for a verified plan; the same seed gives the same plan."""
        rng = np.random.default_rng(seed)
        return self.search.solve(Budget(budget_seconds), rng, progress)

    def diagnose(self, solution: Solution) -> Statistics:
        """What the search finds in the way, where it found no plan; searches need not look."""
        if not isinstance(self.search, SearchStrategy):
            return Statistics()  # registered without the base class, which has a default
        return self.search.diagnose(solution)

    def verify(self, plan: Plan) -> VerifyReport:
        """Replay the whole plan in one rollout and check every claim."""
        verifier: PlanVerifier = self.context.part("verifier")
        return verifier(plan)

    def margin(self, plan: Plan, tell: ProgressCallback = lambda text: None) -> dict[str, float]:
        """How often the plan holds in worlds that are not quite the problem's.

        Shares by how far these are off, executed by the recipe's engine.
        """
        from mamo_core.margin import margin_of

        context = self.context
        return margin_of(context.problem, plan, context.part("backend"), context.robot, tell)


def compose(
    recipe: LoadedRecipe, problem: Problem, registry: Registry, robot: ArmModel | None = None
) -> Planner:
    """Build all parts of a recipe for a problem; ``robot`` is loaded unless it is given.

    Raises:
        InputError: unknown component or robot, wrong options, or a capability that is missing.
        PluginError: a component whose packages are not installed.
    """
    choices = choose(recipe, problem, registry)
    search = next(choice for choice in choices if choice.role == "search")
    context = build_parts(choices, problem, robot)
    return Planner(recipe, context, _build(search, context))


def build_parts(
    choices: Sequence[Choice], problem: Problem, robot: ArmModel | None = None
) -> BuildContext:
    """Build everything but the search, in the order of ``choices``."""
    arm = robot if robot is not None else _load_robot(problem)
    _check_joints(problem, arm)
    context = BuildContext(problem=problem, robot=arm)
    for role, attribute in ((r, _SEVERAL.get(r, r)) for r in BUILD_ORDER if r != "search"):
        chosen = [choice for choice in choices if choice.role == role]
        built = tuple((choice.component.name, _build(choice, context)) for choice in chosen)
        if role == "constraint":
            context = replace(context, constraints=tuple(part for _, part in built))
        elif role == "accept_in":
            context = replace(context, accept_in=built)
        elif role == "action":
            context = replace(context, actions=built)
        elif built:
            context = replace(context, **{attribute: built[0][1]})
        if role == "accept_in" and context.backend is not None:
            # Not before: engines send their context to processes, where functions cannot go.
            (backend,) = (choice for choice in choices if choice.role == "backend")
            engines = VerifiersEngines(backend, context, partial(_engines, choices, arm))
            verifier = make_verifier(context, engines)
            context = replace(context, verifier=verifier, replays=engines.replays)
    return replace(context, engine_for=_engines(choices, arm))


def _engines(choices: Sequence[Choice], arm: ArmModel, backend: Choice | None = None) -> EngineFor:
    """A function that builds the backend for other problems, whose limits may be others, too.

    ``backend``: instead of the one among the choices.
    """
    backends = [choice for choice in choices if choice.role == "backend"]
    known = {c.component.name: c.component for c in choices if c.role == "constraint"}

    def engine_for(
        problem: Problem, changes: Mapping[str, Any] = MappingProxyType({})
    ) -> TransitionModel:
        if not backends:
            raise InputError("a part 'backend' is needed, and the recipe gives none")
        needed = [
            *constraint_choices(problem, lambda name, place: known[name]),
            *(changed(backend or choice, changes) for choice in backends),
        ]
        check_requirements(needed)
        made: TransitionModel = build_parts(needed, problem, arm).part("backend")
        return made

    return engine_for


def _load_robot(problem: Problem) -> ArmModel:
    from mamo_core.robots import load_arm  # reads meshes, which only building needs

    return load_arm(problem.scene.robot)


def _check_joints(problem: Problem, robot: ArmModel) -> None:
    """The types alone do not know how many joints the robot has, nor their limits."""
    states = {"initial": problem.initial.joint_positions, "home": problem.home}
    for name, joints in states.items():
        if joints.size != robot.dof:
            raise InputError(
                f"problem {problem.name!r}: {name} configuration has {joints.size} joints, "
                f"robot {robot.name!r} has {robot.dof}"
            )
        for joint, value, low, high in zip(
            robot.joint_names, joints, robot.lower, robot.upper, strict=True
        ):
            if not low - _SLACK <= value <= high + _SLACK:
                raise InputError(
                    f"problem {problem.name!r}: {name} configuration: {joint} is {value:.6g}, "
                    f"expected {low:.6g} to {high:.6g}"
                )


def _build(choice: Choice, context: BuildContext) -> Any:
    return build_component(choice.role, choice.component, choice.options, context)


def build_component(
    role: str, component: Component, options: Options, context: BuildContext
) -> Any:
    """The part a component builds.

    Raises:
        PluginError: the packages it needs are not installed; the text tells how to get them.
    """
    try:
        return component.build(context, options)
    except ImportError as error:
        hint = (
            f"; install it with: pip install 'mamo[{component.extra}]'" if component.extra else ""
        )
        raise PluginError(f"{role} {component.name!r} cannot be built: {error}{hint}") from error
