"""Searches among fakes: a plan takes milliseconds, and every call is counted."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from mamo_planners.baselines.dogar import Dogar
from mamo_planners.baselines.options import DogarOptions
from mamo_planners.search.execution import Execution
from mamo_planners.search.greedy import GreedySearch
from mamo_planners.search.options import BestFirstOptions, DepthFirstOptions, GreedyOptions
from mamo_planners.search.orders import DepthFirst, order_of
from mamo_planners.search.rearrangement import RearrangementSearch
from mamo_planners.search.run import SearchParts
from mamo_planners.search.stand import Engine
from mamo_planners.search.uncertainty import needed, sampled

from mamo_core.interfaces.arm_planner import ArmPlan, ArmPlanner, ArmPlanStatus
from mamo_core.interfaces.collision_checker import CollisionChecker, CollisionWorld
from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.robots.limits import JointLimits
from mamo_core.testing.fakes import StraightPush, StraightRetrieval
from mamo_core.testing.gantry import GantryKinematics
from mamo_core.testing.quasi_static import QuasiStaticModel
from mamo_core.testing.transition_cases import standard_constraints
from mamo_core.types.geometry import make_pose
from mamo_core.types.mapf import MAPFSolution, MAPFStatus
from mamo_core.types.motion import Motion
from mamo_core.types.region import SweptRegion
from mamo_core.types.solution import Budget
from mamo_core.verify import VerifyReport


class Sidewards(MAPFSolver):
    """Whoever is in the region walks left or right, to a place that no goal penalty forbids."""

    def __init__(self):
        self.problems = []

    def solve(self, problem, budget, rng):
        self.problems.append(problem)
        paths = {agent.name: self._path(problem, agent) for agent in problem.agents}
        return MAPFSolution(MAPFStatus.FEASIBLE, paths)

    def _path(self, problem, agent):
        start = np.array(agent.pose[:2])
        for distance in np.arange(0.0, 0.4, 0.02):
            for side in (1.0, -1.0):
                end = start + np.array([0.0, side * distance])
                if self._good(problem, agent, end):
                    return np.stack([start, end]) if distance else start[None]
        return start[None]

    def _good(self, problem, agent, end):
        inside = (end >= problem.goal_lower + 0.03) & (end <= problem.goal_upper - 0.03)
        pose = make_pose([*end, agent.pose[2]])
        forbidden = [p for p in agent.penalties if np.linalg.norm(p.position - end) <= p.radius]
        return inside.all() and not forbidden and not problem.region.overlaps(agent.shape, pose)


class FreeWorld(CollisionWorld):
    def free(self, configurations):
        return np.ones(len(np.atleast_2d(configurations)), dtype=bool)

    def edges_free(self, starts, ends):
        return self.free(starts)


class NoCollisions(CollisionChecker):
    def world(self, object_poses, *, opening, ignore=(), held=None, margin=0.0):
        return FreeWorld()


class ArmSweepsNothing(NoCollisions):
    """Regions with the cells of ``StraightRetrieval``'s."""

    def __init__(self, problem):
        region = StraightRetrieval(problem).swept_region(problem.initial, None)
        empty = np.full_like(region.lowest, np.inf)
        self._region = SweptRegion(region.origin, region.resolution, empty, region.floor)

    def swept_region(self, path, *, opening, held=None):
        return self._region


class StraightArm(ArmPlanner):
    def plan(self, start, goals, world, rng, *, max_checks=None):
        return ArmPlan(ArmPlanStatus.SOLVED, np.stack([start, goals[0]]), 0, 1)


def greedy(parts, options):
    return GreedySearch(parts, GreedyOptions(**options))


def depth_first(parts, options):
    chosen = DepthFirstOptions(**{"regions": 2, **options})
    return RearrangementSearch(parts, lambda problem, region: DepthFirst(), chosen)


def best_first(parts, options):
    chosen = BestFirstOptions(**{"regions": 2, **options})
    return RearrangementSearch(parts, order_of(chosen), chosen)


def dogar(parts, options):
    return Dogar(parts, ArmSweepsNothing(parts.problem), DogarOptions(**options))


KINDS = {"dogar": dogar, "greedy": greedy, "depth_first": depth_first, "best_first": best_first}


class Search:
    """A search for a tiny scene, its parts at hand."""

    def __init__(
        self,
        problem,
        actions=None,
        verifier=None,
        model=None,
        others=(),
        retrieval=None,
        kind="greedy",
        trial=None,
        clear=lambda motion, state: True,
        **options,
    ):
        self.problem, self.others, self.clear = problem, others, clear
        self.uncertainty, self.trial = options.get("uncertainty"), trial
        self.model = model or QuasiStaticModel(
            problem, GantryKinematics().forward, standard_constraints(problem)
        )
        self.mapf = Sidewards()
        self.told = []
        self.retrieval = retrieval or StraightRetrieval(problem)
        parts = SearchParts(
            problem,
            self.retrieval,
            self.mapf,
            tuple(
                (f"push{n}" if n else "push", a)
                for n, a in enumerate(actions or [StraightPush(problem)])
            ),
            self._execution,
            lambda plan, parameters, executed: (verifier or self.replay)(plan),
        )
        self.search = KINDS[kind](parts, options)

    def _execution(self, statistics, budget, rng):
        limits = JointLimits(np.ones(4), np.full(4, 10.0), np.full(4, 1000.0))
        arm = SimpleNamespace(gripper=SimpleNamespace(closed=0.0), limits=limits)
        engines = [Engine(name, model) for name, model in [("own", self.model), *self.others]]
        tolerated = 0
        if self.uncertainty is not None:
            drawn = sampled(self.problem.scene, self.uncertainty, rng)
            engines = [
                Engine(f"sample_{n}", self.model, values, n == 0) for n, values in enumerate(drawn)
            ]
            tolerated = len(engines) - needed(self.uncertainty.threshold, len(engines))
        self.engines = engines
        parts = (
            arm,
            replace(engines[0], model=self.trial or self.model, continuous=False),
            engines,
            (),
            NoCollisions(),
            StraightArm(),
            lambda motion, states: True,
            self.clear,
            lambda segments, state, opening: True,
        )
        return Execution(self.problem, *parts, statistics, budget, tolerated)

    def replay(self, plan):
        """The whole plan in one rollout."""
        segments = tuple(s for motion in plan.motions for s in motion.segments)
        whole = Motion(segments, plan.motions[0].opening)
        result = self.model.rollout(
            self.problem.initial, whole, options=RolloutOptions(stop_early=False)
        )
        failures = [*map(str, result.violations), *(["stalled"] if result.stalled else [])]
        return VerifyReport(tuple(failures), result)

    def solve(self, seed=0, seconds=float("inf")):
        return self.search.solve(Budget(seconds), np.random.default_rng(seed), self.told.append)


@pytest.fixture
def search_of():
    return Search


def words(solution):
    """The actions in short: kind, object, where to in cm."""
    if solution.plan is None:
        return None
    return [
        f"{a.kind} {a.object_name} to {100 * a.path[-1][0]:.0f},{100 * a.path[-1][1]:.0f}"
        for a in solution.plan.actions
    ]


@pytest.fixture(scope="session")
def in_words():
    return words
