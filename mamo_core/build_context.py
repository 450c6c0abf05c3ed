"""What parts are built with: the problem, and the parts that were built before them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol

from mamo_core.errors import InputError
from mamo_core.interfaces.action_generator import ActionGenerator
from mamo_core.interfaces.arm_planner import ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.interfaces.retrieval import RetrievalPlanner
from mamo_core.interfaces.transition_model import Replay, TransitionModel
from mamo_core.robots.model import ArmModel
from mamo_core.types.deviation import NEAR, Deviation
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.solution import Plan

if TYPE_CHECKING:
    from mamo_core.verify import VerifyReport


class PlanVerifier(Protocol):
    """Replays a plan and checks every claim.

    ``parameters``: other masses and frictions than the problem's. ``executed``: what the backend
    did in a continuous execution, one result for each motion, which then is not repeated.
    ``replays``: whether to ask the worlds close to the problem's, which some searches have done;
    ``friction``: whether fingers and friction alone must hold what is carried.
    """

    def __call__(
        self,
        plan: Plan,
        parameters: ParameterOverrides | None = None,
        executed: Sequence[RolloutResult] | None = None,
        replays: bool = True,
        friction: bool = True,
    ) -> VerifyReport: ...


class EngineFor(Protocol):
    """Builds the backend for a problem; ``changes``: options that are not those of the recipe.

    Raises:
        InputError: an option that the backend does not have, or a value it cannot have.
    """

    def __call__(
        self, problem: Problem, changes: Mapping[str, Any] = MappingProxyType({})
    ) -> TransitionModel: ...


class Replays(Protocol):
    """The worlds in which plans must hold.

    ``problem``: the same one with other limits. ``extra``: so many more worlds, ``wider`` off.
    """

    def __call__(
        self, problem: Problem | None = None, wider: Deviation = NEAR, extra: int = 0
    ) -> tuple[Replay, ...]: ...


@dataclass(frozen=True, eq=False)
class BuildContext:
    """What a component's build function receives: the problem and the parts built before it.

    Built in this order: constraints, backend, accept_in, kinematics, collision, arm_planner,
    retrieval, mapf, actions, search. A part that is not built yet, or not in the recipe, is None.
    ``accept_in``: other engines, by name, in which actions and plans must be valid, too.
    ``verifier`` replays a plan with all of them; it is there as soon as they are. ``replays``:
    worlds close to the problem's in which plans must hold, for searches that ask them early.
    ``engine_for``,
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
    replays: Replays | None = None
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
