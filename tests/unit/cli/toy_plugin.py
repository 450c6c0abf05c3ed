"""A plugin with a toy for every role; the conftest installs it for the commands under test."""

import signal
from types import SimpleNamespace
from typing import Literal

import numpy as np

from mamo_core.errors import InputError
from mamo_core.hookspecs import Component, Options, hookimpl
from mamo_core.types.action import RearrangementAction
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.region import SweptRegion
from mamo_core.types.solution import Plan, Solution, SolutionStatus, Statistics

WARMED = []


class BackendOptions(Options):
    breaks: bool = False


class SearchOptions(Options):
    outcome: Literal["solved", "exhausted", "proved", "crash", "interrupt"] = "solved"


def backend(context, options):
    return SimpleNamespace(breaks=options.breaks)


def broken(context, options):
    return SimpleNamespace(breaks=True)


def anything(context, options):
    return object()


class ToyRetrieval:
    """Everything right of y = 0 is in the way; a target left of it cannot be reached."""

    def __init__(self, problem):
        self.problem = problem

    def plan(self, state, rng, *, ignore_movables=False):
        reachable = state.object_poses[self.problem.scene.target_index][1] > 0.0
        return SimpleNamespace(motion=motion() if reachable else None)

    def swept_region(self, state, motion):
        return SweptRegion([0.0, 0.0], 0.1, np.zeros((10, 10)), 0.0)


def motion():
    path = Trajectory.still(np.zeros(7), 1.0)
    return Motion((MotionSegment(SegmentKind.TRANSIT, path, 0.0),), 0.0)


class ToySearch:
    def __init__(self, options):
        self.outcome = options.outcome

    def solve(self, budget, rng, progress):
        progress(f"searching with [{self.outcome}]")
        if self.outcome == "crash":
            raise RuntimeError("toys\nbreak")
        if self.outcome == "interrupt":
            signal.raise_signal(signal.SIGINT)
        statistics = Statistics()
        statistics.counts["rollouts"] += 4
        statistics.seconds["mapf"] += 0.25
        statistics.failed("o1", "push", "no_ik", 3)
        statistics.failed("o1", "push", "stalled", 7)
        if self.outcome == "solved":
            path = np.array([[0.0, rng.random()]])
            plan = Plan((RearrangementAction("push", "o1", motion(), path),), motion())
            return Solution(SolutionStatus.SOLVED, plan, statistics)
        status = {
            "exhausted": SolutionStatus.BUDGET_EXHAUSTED,
            "proved": SolutionStatus.NO_PLAN_PROVED,
        }[self.outcome]
        return Solution(status, None, statistics, reason="the target is walled in")


def greeting(bench, options):
    def toy_greeting(word: str, times: int = 1) -> None:
        """Greet the toys."""
        if word == "inside":
            raise InputError(f"word {word!r}: too deep")
        bench.print_json("toy greeting", {"words": [word] * times, "levels": bench.levels})

    return toy_greeting


def unfinished(bench, options):
    import nothing_like_it  # noqa: F401


def warm_up():
    WARMED.append("toy")


@hookimpl
def mamo_backends():
    return [
        Component("toy_engine", backend, BackendOptions, "falls [never]"),
        Component("toy_wreck", broken),
    ]


@hookimpl
def mamo_kinematics():
    return [Component("toy", anything)]


@hookimpl
def mamo_collision_checkers():
    return [Component("toy", anything)]


@hookimpl
def mamo_arm_planners():
    return [Component("toy", anything)]


@hookimpl
def mamo_retrieval_planners():
    return [Component("toy", lambda context, options: ToyRetrieval(context.problem))]


@hookimpl
def mamo_actions():
    return [Component("toy", anything)]


@hookimpl
def mamo_searches():
    return [Component("toy", lambda context, options: ToySearch(options), SearchOptions)]


@hookimpl
def mamo_commands():
    return [Component("toy_greeting", greeting), Component("toy_unfinished", unfinished)]
