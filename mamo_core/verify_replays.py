"""Whether a plan holds in worlds close to the problem's: what hangs on a rounding was luck."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from mamo_core.interfaces.transition_model import Replay
from mamo_core.types.motion import Motion
from mamo_core.types.rollout import ParameterOverrides, RolloutResult


def check_replays(
    motions: Sequence[Motion],
    replays: Sequence[Replay],
    parameters: ParameterOverrides | None = None,
) -> list[str]:
    """In words, the first world in which the plan fails, and why; empty if it holds in all."""
    for replay in replays:
        for result in replayed(motions, replay, parameters):
            if not result.valid:
                return [f"in the replay {replay.name}: {_why(result)}"]
    return []


def replayed(
    motions: Sequence[Motion], replay: Replay, parameters: ParameterOverrides | None = None
) -> Iterator[RolloutResult]:
    """What each motion does, up to the first that breaks something.

    Each motion begins from rest, where the arm first may touch something, and ends where it may do
    so last (``Motion.touching``).
    """
    state = replay.start
    for motion in motions:
        touching = motion.touching()
        begin = state.with_joints(touching.start)
        result = replay.model.rollout(begin, touching, parameters=parameters)
        yield result
        if not result.valid:
            return
        state = result.final_state


def _why(result: RolloutResult) -> str:
    if result.lost is not None:
        return result.lost
    if result.violations:
        return str(result.violations[0])
    return "the arm could not follow its trajectory"
