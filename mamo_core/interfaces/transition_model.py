"""What happens when the arm moves: the only slow call of a search."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import SceneState


@dataclass(frozen=True)
class RolloutOptions:
    """How to run.

    ``stop_early``: end at the first violation. ``trace_step``: record every so many seconds.
    ``keep``: put a ``continuation`` into the result, where the model can.
    """

    stop_early: bool = True
    trace_step: float | None = None
    keep: bool = False


class TransitionModel(ABC):
    """Physics of one problem. ``rollout`` is a function of its arguments, whatever ran before."""

    @abstractmethod
    def rollout(
        self,
        state: SceneState,
        motion: Motion,
        *,
        parameters: ParameterOverrides | None = None,
        options: RolloutOptions | None = None,
        continue_from: Any = None,
    ) -> RolloutResult:
        """Execute ``motion`` from ``state`` (objects at rest, the arm at ``state``'s joints).

        Every interaction constraint sees every step. With ``continue_from``, the ``continuation``
        of an earlier result of this model, the engine goes on exactly from there and ``state`` is
        its final state (capability ``exact_continuation``; otherwise ValueError).
        """

    def tool_pose(self, state: SceneState) -> Array:
        """Where the engine sees the tool link's frame (7,), world, with the arm at ``state``.

        For comparison with our kinematics (capability ``tool_pose``).
        """
        raise NotImplementedError(f"{type(self).__name__} cannot tell where the tool is")

    def rollout_batch(
        self,
        states: Sequence[SceneState],
        motions: Sequence[Motion],
        *,
        parameters: Sequence[ParameterOverrides | None] | None = None,
        options: RolloutOptions | None = None,
        continue_from: Sequence[Any] | None = None,
    ) -> list[RolloutResult]:
        """The same as a loop of ``rollout``; engines that can run side by side override it."""
        overrides = parameters if parameters is not None else [None] * len(states)
        tokens = continue_from if continue_from is not None else [None] * len(states)
        return [
            self.rollout(state, motion, parameters=override, options=options, continue_from=token)
            for state, motion, override, token in zip(
                states, motions, overrides, tokens, strict=True
            )
        ]


@dataclass(frozen=True, eq=False)
class Replay:
    """A world in which a plan must hold, too: another ``start``, or a finer ``model``."""

    name: str
    model: TransitionModel
    start: SceneState
