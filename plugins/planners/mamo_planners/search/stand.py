"""Where an execution stands, as values: candidates are tried from there and change nothing."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.types.motion import Motion
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import SceneState


@dataclass(frozen=True, eq=False)
class Engine:
    """An engine that executes the plan, with other masses and frictions if some are given.

    ``continuous``: it executes everything; otherwise each action from its sweep on, from rest.
    ``nearby``: it is one of the worlds close to the problem's, in which all must hold.
    """

    name: str
    model: TransitionModel
    parameters: ParameterOverrides | None = None
    continuous: bool = True
    nearby: bool = False


@dataclass(frozen=True, eq=False)
class Line:
    """Where an engine stands in the execution, and how to go on there.

    ``executed``: what it did so far, one result for each motion.
    """

    engine: Engine
    state: SceneState
    token: object = None
    executed: tuple[RolloutResult, ...] = ()

    def after(self, result: RolloutResult, motion: Motion) -> Line:
        """The next motion starts where this one commanded the arm to stop."""
        token = result.continuation if self.engine.continuous else None
        state = result.final_state.with_joints(motion.end)
        # A snapshot is large, and of all that were executed only the last is needed.
        executed = (*self.executed, replace(result, continuation=None))
        return replace(self, state=state, token=token, executed=executed)


@dataclass(frozen=True, eq=False)
class Stand:
    """Where the execution stands in every engine that has followed so far; the first one leads.

    ``predicted``: nobody has executed what led here.
    """

    leading: Line
    others: tuple[Line, ...] = ()
    predicted: bool = False

    @property
    def state(self) -> SceneState:
        """What the search plans from."""
        return self.leading.state

    def believed(self, state: SceneState) -> Stand:
        """Every engine is said to be in ``state``, at rest."""
        leading, *others = (
            replace(line, state=state, token=None, executed=())
            for line in (self.leading, *self.others)
        )
        return Stand(leading, tuple(others), predicted=True)
