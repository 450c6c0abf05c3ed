"""What a rollout of an action or a retrieval must not show."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.types.action import RearrangementAction
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import ROBOT_NAME, SceneState
from mamo_core.types.solution import Statistics
from mamo_planners.search.safety import SafetyMargin

Accept = Callable[[SceneState], bool]
Fault = tuple[str, tuple[str, ...]]
"""A cause, and the names of those involved in it."""


class Judge:
    """Says whether a rollout is good, and counts why not."""

    def __init__(
        self, collision: CollisionChecker, safe: SafetyMargin, statistics: Statistics
    ) -> None:
        self._collision, self._safe, self._stats = collision, safe, statistics

    def good(
        self, result: RolloutResult, action: RearrangementAction, accept: Accept | None
    ) -> bool:
        """Whether the action is valid, moves its object safely, and passes ``accept``."""
        fault = next(self._faults(result, action, accept), None)
        if fault is not None:
            cause, involved = fault
            self._stats.failed(action.object_name, action.kind, cause, involved=involved)
        return fault is None

    def retrieved(self, result: RolloutResult) -> bool:
        """Whether a retrieval is valid."""
        for cause, involved in _broken(result):
            self._stats.failed("arm", "retrieval", cause, involved=involved)
        return result.valid

    def holds(self, result: RolloutResult, subject: str, kind: str) -> bool:
        """Whether a motion breaks nothing in a world close to the problem's."""
        if not result.valid:
            involved = next((names for _, names in _broken(result)), ())
            self._stats.failed(subject, kind, "not_valid_nearby", involved=involved)
        return result.valid

    def _faults(
        self, result: RolloutResult, action: RearrangementAction, accept: Accept | None
    ) -> Iterator[Fault]:
        yield from _broken(result)
        if not self._safe.kept(result):
            yield "too_close", ()
        if action.object_name not in result.moved:
            yield "unmoved", ()
        end = action.motion.end
        world = self._collision.world(
            result.final_state.object_poses, opening=action.motion.segments[-1].opening
        )
        if not world.free(end)[0]:
            yield "arm_blocked_after", ()
        if accept is not None and not accept(result.final_state):
            yield "no_gain", ()


def _broken(result: RolloutResult) -> Iterator[Fault]:
    """Why a rollout is not valid; of its violations the first."""
    if result.lost is not None:
        yield result.lost, ()
    if result.stalled:
        yield "stalled", touched_by_arm(result)
    for violation in result.violations[:1]:
        pair = () if violation.other is None else (violation.other,)
        yield violation.constraint, (violation.subject, *pair)


def touched_by_arm(result: RolloutResult) -> tuple[str, ...]:
    """Names of what the arm touched."""
    arm = {pair for pair in result.contacts if ROBOT_NAME in pair}
    return tuple(sorted({name for pair in arm for name in pair} - {ROBOT_NAME}))
