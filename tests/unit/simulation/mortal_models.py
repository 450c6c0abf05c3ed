"""Models that end, or hang, in the process they run in."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from mamo_core.build_context import BuildContext
from mamo_core.hookspecs import Component, Options, hookimpl
from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.simulation.isolated import isolated
from mamo_core.testing.gantry import GantryKinematics
from mamo_core.testing.quasi_static import QuasiStaticModel
from mamo_core.testing.transition_cases import gantry_cases, standard_constraints
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import SceneState

CASES = gantry_cases()
ENDS: dict[str, Callable[[], None]] = {
    "abort": os.abort,
    "kill": lambda: os.kill(os.getpid(), signal.SIGKILL),
    "exit": lambda: os._exit(3),
    "hang": lambda: time.sleep(600.0),
}


def fake() -> QuasiStaticModel:
    problem = CASES.problem
    return QuasiStaticModel(problem, GantryKinematics().forward, standard_constraints(problem))


class DiesOfCrashes(TransitionModel):
    """Ends whenever it is given the crash; all else goes well."""

    def __init__(self, end: str) -> None:
        self._end, self._sound = ENDS[end], fake()

    def rollout(self, state: SceneState, motion: Motion, **more: Any) -> RolloutResult:
        if motion.duration > CASES.push.duration + 1.0:
            self._end()
        return self._sound.rollout(state, motion, **more)

    def tool_pose(self, state: SceneState) -> Array:
        self._end()
        raise AssertionError("it has not ended")


def refuses() -> TransitionModel:
    raise ValueError("the engine cannot build this scene")


class DiesOnce(TransitionModel):
    """A real engine whose process ends at its second rollout, unless the file exists already."""

    def __init__(self, context: BuildContext, end: str, dead: str) -> None:
        from mamo_pybullet.model import make_model
        from mamo_pybullet.options import PyBulletOptions

        self._end, self._dead, self._calls = ENDS[end], Path(dead), 0
        parts = context.problem, context.robot, context.constraints
        self._sound = make_model(*parts, PyBulletOptions())

    def rollout(self, state: SceneState, motion: Motion, **more: Any) -> RolloutResult:
        self._calls += 1
        if self._calls == 2 and not self._dead.exists():
            self._dead.touch()
            self._end()
        return self._sound.rollout(state, motion, **more)


class MortalOptions(Options):
    end: str
    dead: str


def build(context: BuildContext, options: MortalOptions) -> TransitionModel:
    return isolated(partial(DiesOnce, context, options.end, options.dead), 1, 60.0)


@hookimpl
def mamo_backends() -> list[Component]:
    return [Component("mortal", build, MortalOptions, provides=frozenset({"exact_continuation"}))]
