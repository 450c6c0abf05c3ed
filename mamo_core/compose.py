"""From a recipe and a problem to parts that know each other."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from mamo_core.config import Located, validated
from mamo_core.errors import InputError, PluginError
from mamo_core.hookspecs import Component, Options
from mamo_core.interfaces.action_generator import ActionGenerator
from mamo_core.interfaces.arm_planner import ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.interfaces.retrieval import RetrievalPlanner
from mamo_core.interfaces.search_strategy import ProgressCallback, SearchStrategy
from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.plugins import Registry
from mamo_core.recipes import LoadedRecipe
from mamo_core.robots.model import ArmModel
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.solution import Budget, Plan, Solution, Statistics

if TYPE_CHECKING:
    from mamo_core.verify import VerifyReport


class PlanVerifier(Protocol):
    """Replays a plan and checks every claim.

    ``parameters``: other masses and frictions than the problem's. ``executed``: what the backend
    did in a continuous execution, one result for each motion, which then is not repeated.
    """

    def __call__(
        self,
        plan: Plan,
        parameters: ParameterOverrides | None = None,
        executed: Sequence[RolloutResult] | None = None,
    ) -> VerifyReport: ...


class EngineFor(Protocol):
    """Builds the backend for a problem; ``changes``: options that are not those of the recipe.

    Raises:
        InputError: an option that the backend does not have, or a value it cannot have.
    """

    def __call__(
        self, problem: Problem, changes: Mapping[str, Any] = MappingProxyType({})
    ) -> TransitionModel: ...


@dataclass(frozen=True, eq=False)
class BuildContext:
    """What a component's build function receives: the problem and the parts built before it.

    Built in this order: constraints, backend, accept_in, kinematics, collision, arm_planner,
    retrieval, mapf, actions, search. A part that is not built yet, or not in the recipe, is None.
    ``accept_in``: other engines, by name, in which actions and plans must be valid, too.
    ``verifier`` replays a plan with all of them; it is there as soon as they are. ``engine_for``,
    for the search alone, builds the backend for another problem, such as this one without some of
    its objects, or with other options.
    """

    problem: Problem
    robot: ArmModel
    constraints: tuple[InteractionConstraint, ...] = ()
    backend: TransitionModel | None = None
    accept_in: tuple[tuple[str, TransitionModel], ...] = ()
    kinematics: Kinematics | None = None
    collision: CollisionChecker | None = None
    arm_planner: ArmPlanner | None = None
    retrieval: RetrievalPlanner | None = None
    mapf: MAPFSolver | None = None
    actions: tuple[tuple[str, ActionGenerator], ...] = ()
    verifier: PlanVerifier | None = None
    engine_for: EngineFor | None = None

    def part(self, role: str) -> Any:
        """The part built for ``role``, for components that cannot do without it.

        Raises:
            InputError: the recipe has no such part, or it is built later.
        """
        built = getattr(self, role)
        if built is None:
            raise InputError(f"a part {role!r} is needed, and the recipe gives none before this")
        return built


BUILD_ORDER = (
    "constraint",
    "backend",
    "accept_in",
    "kinematics",
    "collision",
    "arm_planner",
    "retrieval",
    "mapf",
    "action",
    "search",
)
_SLACK = 1e-6  # rad; files may hold rounded joint positions
_SEVERAL = {"constraint": "constraints", "action": "actions"}
_KIND = {"accept_in": "backend"}
"""Roles that are filled with components of another role."""


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
        return make_verifier(self.context)(plan)


@dataclass(frozen=True, eq=False)
class Choice:
    """A component with its options, and the place that asked for it."""

    role: str
    component: Component
    options: Options
    place: str


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


def choose(
    recipe: LoadedRecipe,
    problem: Problem,
    registry: Registry,
    roles: Collection[str] = BUILD_ORDER,
) -> tuple[Choice, ...]:
    """The components of some roles, in building order, checked against each other.

    Raises:
        InputError: unknown component, wrong options, a capability that is missing, or a search
            that does not plan for the task of the problem.
    """
    choices: list[Choice] = []
    for role in BUILD_ORDER:
        if role == "constraint" and role in roles:
            choices += _constraint_choices(problem, partial(registry.component, role))
        elif role == "accept_in" and role in roles:
            choices += _other_engines(recipe, registry)
        elif role in roles:
            choices += [
                _choice(registry, role, part.name, part.options, part.place)
                for part in recipe.parts(role)
            ]
    check_requirements(choices)
    for choice in choices:
        if choice.role == "search":
            _check_task(choice, problem)
    return tuple(choices)


def check_requirements(choices: Sequence[Choice]) -> None:
    """Refuse a recipe with a component that needs what another one does not provide."""
    for choice in choices:
        for role, needed in choice.component.requires.items():
            others = [other for other in choices if role in (other.role, _KIND.get(other.role))]
            if not others:
                raise InputError(f"{choice.place}: {_named(choice)} needs a part {role!r}")
            for other in others:
                _check_provides(choice, other, needed)
        for role, needed in choice.options.needs().items():
            for other in (other for other in choices if other.role == role):
                _check_provides(choice, other, needed)


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
            context = replace(context, verifier=make_verifier(context))
    # Not before: engines send their context to processes, where functions cannot go.
    return replace(context, engine_for=_engines(choices, arm))


def _engines(choices: Sequence[Choice], arm: ArmModel) -> EngineFor:
    """A function that builds the backend for other problems, whose limits may be others, too."""
    backends = [choice for choice in choices if choice.role == "backend"]
    known = {c.component.name: c.component for c in choices if c.role == "constraint"}

    def engine_for(
        problem: Problem, changes: Mapping[str, Any] = MappingProxyType({})
    ) -> TransitionModel:
        if not backends:
            raise InputError("a part 'backend' is needed, and the recipe gives none")
        changed = [_changed(choice, changes) for choice in backends]
        needed = [*_constraint_choices(problem, lambda name, place: known[name]), *changed]
        check_requirements(needed)
        backend: TransitionModel = build_parts(needed, problem, arm).part("backend")
        return backend

    return engine_for


def _changed(choice: Choice, changes: Mapping[str, Any]) -> Choice:
    """The same component with some other options."""
    own = choice.options.model_dump(exclude_unset=True)
    place = f"{choice.place}: changed options of {_named(choice)}"
    return replace(
        choice,
        options=validated(choice.component.options, Located({**own, **changes}, place)),
    )


def make_verifier(context: BuildContext) -> PlanVerifier:
    """A function that verifies plans for the problem of ``context`` with all its engines.

    The first engine that finds something wrong ends it; its name stands before what it found,
    unless it is the backend.
    """
    model = context.backend
    if model is None:
        raise ValueError("verification needs a backend")

    def check(
        plan: Plan,
        parameters: ParameterOverrides | None = None,
        executed: Sequence[RolloutResult] | None = None,
    ) -> VerifyReport:
        from mamo_core.verify import verify, verify_executed

        problem, robot = context.problem, context.robot
        if executed is None:
            report = verify(problem, plan, model, robot, parameters=parameters)
        else:
            report = verify_executed(problem, plan, executed, robot)
        for name, other in context.accept_in:
            if not report.ok:
                break
            theirs = verify(problem, plan, other, robot, parameters=parameters)
            failures = tuple(f"{name}: {failure}" for failure in theirs.failures)
            outside_cpu = report.outside_cpu + theirs.outside_cpu
            report = replace(report, failures=failures, outside_cpu=outside_cpu)
        return report

    return check


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


def _constraint_choices(problem: Problem, find: Callable[[str, str], Component]) -> list[Choice]:
    """``find``: a constraint by its name, and the place that asks for it."""
    place = f"problem {problem.name!r}: constraints"
    choices = []
    for spec in problem.constraints:
        component = find(spec.name, place)
        options = Located(dict(spec.options), f"{place}: {spec.name}")
        choices.append(
            Choice("constraint", component, validated(component.options, options), place)
        )
    return choices


def _other_engines(recipe: LoadedRecipe, registry: Registry) -> list[Choice]:
    """The engines of ``accept_in`` that are not the backend itself, the cheapest first."""
    own = {part.name for part in recipe.parts("backend")}
    others = [
        replace(_choice(registry, "backend", p.name, p.options, p.place), role="accept_in")
        for p in recipe.parts("accept_in")
        if p.name not in own
    ]
    return sorted(others, key=lambda choice: choice.component.cost)


def _choice(registry: Registry, role: str, name: str, options: Located, place: str) -> Choice:
    component = registry.component(role, name, place)
    return Choice(role, component, validated(component.options, options), place)


def _check_provides(choice: Choice, other: Choice, needed: Collection[str]) -> None:
    missing = sorted(set(needed) - other.component.provides)
    if missing:
        provided = ", ".join(sorted(other.component.provides)) or "nothing"
        raise InputError(
            f"{choice.place}: {_named(choice)} needs {', '.join(missing)} from the {other.role}, "
            f"but {_named(other)} provides {provided}"
        )


def _check_task(search: Choice, problem: Problem) -> None:
    if problem.task not in search.component.tasks:
        tasks = ", ".join(sorted(search.component.tasks))
        raise InputError(
            f"{search.place}: {_named(search)} does not plan for the task {problem.task.value!r} "
            f"of problem {problem.name!r} (it does for: {tasks})"
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


def _named(choice: Choice) -> str:
    return f"{choice.role} {choice.component.name!r}"
