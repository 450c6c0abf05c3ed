"""From a recipe and a problem to parts that know each other."""

from __future__ import annotations

from dataclasses import dataclass

from mamo_core.interfaces.action_generator import ActionGenerator
from mamo_core.interfaces.arm_planner import ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.interfaces.retrieval import RetrievalPlanner
from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.robots.model import ArmModel
from mamo_core.types.problem import Problem


@dataclass(frozen=True, eq=False)
class BuildContext:
    """What a component's build function receives: the problem and the parts built before it.

    Built in this order: constraints, backend, kinematics, collision, arm_planner, retrieval,
    mapf, actions, search. A part that is not built yet, or not in the recipe, is None.
    """

    problem: Problem
    robot: ArmModel
    constraints: tuple[InteractionConstraint, ...] = ()
    backend: TransitionModel | None = None
    kinematics: Kinematics | None = None
    collision: CollisionChecker | None = None
    arm_planner: ArmPlanner | None = None
    retrieval: RetrievalPlanner | None = None
    mapf: MAPFSolver | None = None
    actions: tuple[tuple[str, ActionGenerator], ...] = ()
