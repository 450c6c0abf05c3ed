"""What holds for all tests: drawn examples are the same in every run, however slow the machine."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import settings

from mamo_core.interfaces.arm_planner import ArmPlan, ArmPlanner, ArmPlanStatus
from mamo_core.testing.flat_checker import FlatChecker
from mamo_core.testing.gantry import UprightGantry
from mamo_core.testing.gantry_arm import gantry_arm
from mamo_core.testing.quasi_static import QuasiStaticModel
from mamo_core.testing.transition_cases import standard_constraints
from mamo_core.types.solution import Budget
from mamo_core.verify import verify

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")


class StraightOrNot(ArmPlanner):
    """The straight motion, if it is free."""

    always = False

    def plan(self, start, goals, world, rng, *, max_checks=None):
        free = self.always or bool(world.edges_free(start[None, :], goals[:1])[0])
        status = ArmPlanStatus.SOLVED if free else ArmPlanStatus.EXHAUSTED
        return ArmPlan(status, np.stack([start, goals[0]]) if free else None, 0, 1)


class Recording(QuasiStaticModel):
    """A fake engine that keeps the motions it was shown."""

    def __init__(self, problem):
        super().__init__(problem, UprightGantry().forward, standard_constraints(problem))
        self.motions = []

    def rollout(self, state, motion, **settings):
        self.motions.append(motion)
        return super().rollout(state, motion, **settings)


THESIS = {"connect": False, "enough": 8, "growth": 0.0, "via": 0.0, "vary": 0.0}
"""Options beyond the thesis, off: the golden searches are of Algorithm 3."""

COARSE = {"large_step_deg": 2.0}
"""The gantry's steps are metres: 3.5 cm."""


class Reaching:
    """Parts of a planner that reaches with the gantry; ``engines``: all that were built."""

    def __init__(self, problem, **changes):
        from mamo_planners.reaching.stand import ReachingParts

        self.problem, self.engines = problem, []
        self.arm = gantry_arm()
        self.parts = ReachingParts(
            problem,
            self.arm,
            UprightGantry(),
            FlatChecker(problem),
            StraightOrNot(),
            self.engine_for(problem),
            self.verified,
        )
        self.parts = replace(self.parts, **changes)

    def engine_for(self, problem):
        self.engines.append(Recording(problem))
        return self.engines[-1]

    def verified(self, plan):
        """By an engine of its own, in one continuous rollout, as ``mamo verify`` does."""
        return verify(self.problem, plan, Recording(self.problem), self.arm)

    def spamp(self, **options):
        from mamo_planners.reaching.options import SpampOptions
        from mamo_planners.reaching.spamp import Spamp

        return Spamp(self.parts, SpampOptions(**{**COARSE, **THESIS, **options}))

    def selective(self, **options):
        from mamo_planners.baselines.options import SelectiveSimulationOptions
        from mamo_planners.baselines.selective_simulation import SelectiveSimulation

        chosen = SelectiveSimulationOptions(**{**COARSE, **options})
        return SelectiveSimulation(self.parts, self.engine_for, chosen)

    @staticmethod
    def solve(search, seed=0, seconds=float("inf")):
        told = []
        return search.solve(Budget(seconds), np.random.default_rng(seed), told.append)


@pytest.fixture(scope="session")
def reaching():
    return Reaching
