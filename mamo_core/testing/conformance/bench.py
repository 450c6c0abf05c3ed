"""What a check works with, and how it says that something is not so."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NoReturn

from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.robots.model import ArmModel
from mamo_core.testing.transition_cases import TransitionCases
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import RolloutResult

MakeModel = Callable[[Problem, ArmModel, tuple[InteractionConstraint, ...]], TransitionModel]
"""A NEW model of a problem."""

NewProcess = Callable[[Problem, Motion], RolloutResult]
"""Execute a motion from the initial state in a new process, with the standard constraints."""


@dataclass(frozen=True, eq=False)
class Bench:
    """A backend on the bench.

    ``make``: in this process, where the backend has the choice; ``make_default``: as users get it.
    ``arm`` is the gantry, which the problems of the suite use; ``cases``: its scripted motions.
    """

    make: MakeModel
    make_default: MakeModel
    in_new_process: NewProcess
    capabilities: frozenset[str]
    arm: ArmModel
    cases: TransitionCases


class CheckFailedError(AssertionError):
    """A backend does not keep a promise; the text says which and by how much."""


def fail(text: str) -> NoReturn:
    """End the check."""
    raise CheckFailedError(text)


def require(condition: object, text: str) -> None:
    """Fail unless the condition holds."""
    if not condition:
        fail(text)
