"""What a rollout of an action or a retrieval must not show."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.types.action import RearrangementAction
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Statistics
from mamo_planners.search.safety import SafetyMargin

Accept = Callable[[SceneState], bool]


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
        cause = next(self._faults(result, action, accept), None)
        if cause is not None:
            self._stats.failed(action.object_name, action.kind, cause)
        return cause is None

    def retrieved(self, result: RolloutResult) -> bool:
        """Whether a retrieval is valid."""
        for cause in _broken(result):
            self._stats.failed("arm", "retrieval", cause)
        return result.valid

    def _faults(
        self, result: RolloutResult, action: RearrangementAction, accept: Accept | None
    ) -> Iterator[str]:
        yield from _broken(result)
        if not self._safe.kept(result):
            yield "too_close"
        if action.object_name not in result.moved:
            yield "unmoved"
        end = action.motion.end
        world = self._collision.world(
            result.final_state.object_poses, opening=action.motion.segments[-1].opening
        )
        if not world.free(end)[0]:
            yield "arm_blocked_after"
        if accept is not None and not accept(result.final_state):
            yield "no_gain"


def _broken(result: RolloutResult) -> Iterator[str]:
    """Why a rollout is not valid; of its violations the first."""
    if result.lost is not None:
        yield result.lost
    if result.stalled:
        yield "stalled"
    for violation in result.violations[:1]:
        yield violation.constraint
