"""Whether a plan holds in worlds close to the problem's: what hangs on a rounding was luck."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.interfaces.transition_model import Replay
from mamo_core.robots.model import ArmModel
from mamo_core.robots.passage import passes
from mamo_core.types.motion import Motion
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import Scene, SceneState

Simulate = Callable[[SceneState, Motion], RolloutResult]


def check_replays(
    motions: Sequence[Motion],
    replays: Sequence[Replay],
    checker: CollisionChecker,
    scene: Scene,
    robot: ArmModel,
    parameters: ParameterOverrides | None = None,
) -> list[str]:
    """In words, the first world in which the plan fails, and why; empty if it holds in all.

    ``checker``: the exact one.
    """
    for replay in replays:
        for result in _replayed(motions, replay, checker, scene, robot, parameters):
            if not result.valid:
                return [f"in the replay {replay.name}: {_why(result)}"]
    return []


def _replayed(
    motions: Sequence[Motion],
    replay: Replay,
    checker: CollisionChecker,
    scene: Scene,
    robot: ArmModel,
    parameters: ParameterOverrides | None,
) -> Iterator[RolloutResult]:
    """What each motion does, from rest, up to the first that breaks something."""

    def simulate(state: SceneState, motion: Motion) -> RolloutResult:
        return replay.model.rollout(state, motion, parameters=parameters)

    state = replay.start
    for motion in motions:
        result = _executed(motion, state, simulate, checker, scene, robot)
        yield result
        if not result.valid:
            return
        state = result.final_state.with_joints(motion.end)


def _executed(
    motion: Motion,
    state: SceneState,
    simulate: Simulate,
    checker: CollisionChecker,
    scene: Scene,
    robot: ArmModel,
) -> RolloutResult:
    """What a motion does from rest.

    Simulated is where it may touch something, and all of it where the rest does so in this world.
    """
    before, touching, after = motion.parts()
    if passes(checker, scene, robot, before, state, motion.opening):
        result = simulate(state.with_joints(touching.start), touching)
        opening = touching.segments[-1].opening
        if not result.valid or passes(checker, scene, robot, after, result.final_state, opening):
            return result
    return simulate(state, motion)


def _why(result: RolloutResult) -> str:
    if result.lost is not None:
        return result.lost
    if result.violations:
        return str(result.violations[0])
    return "the arm could not follow its trajectory"
