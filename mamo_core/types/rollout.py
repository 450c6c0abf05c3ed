"""What a transition model reports: one observation per step, and the result of a rollout."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from mamo_core.types.geometry import Array, BoolArray, IntArray
from mamo_core.types.scene import SceneState

ROBOT = 0
"""Entity number of the robot; objects follow in scene order, then fixtures."""


class StepObservation(NamedTuple):
    """What every engine shows the constraints after every step: a tuple, as that is made quickly.

    ``positions`` (n, 3) m and ``z_axes`` (n, 3), world; ``velocities`` (n, 3) m/s of the centres;
    ``contacts`` (k, 2) entity numbers, each pair in ascending order; ``depths`` (k,): how far they
    reach into each other, m, 0 or less where they only touch; ``held``: place of the object in the
    hand (attached to it, being closed on, or let go of), or -1.
    """

    time: float
    positions: Array
    z_axes: Array
    velocities: Array
    contacts: IntArray
    depths: Array
    held: int = -1


class Watch(NamedTuple):
    """Which steps nobody has to look at; a world that passes over some notes what touched in them.

    After such a step everything is ``within`` (``mamo_core.constraints.kernels``) ``bounds`` (n, 6)
    and ``forbidden`` (e, e), nothing reaches deeper than ``deepest`` (m) into something else, apart
    from the hand into the entity ``gripped``, and no joint is more than ``lag`` (rad) from where it
    should be.
    ``touched`` (e, e): gets True at the pairs, in ascending order, that touch. A tuple, which
    compiled code can take.
    """

    bounds: Array
    forbidden: BoolArray
    deepest: float
    gripped: int
    lag: float
    touched: BoolArray


@dataclass(frozen=True)
class Violation:
    """A broken constraint: ``subject`` (and ``other``, for contacts) at ``time`` s.

    ``value`` and ``limit`` carry the unit of the constraint (rad, m/s, m; contacts 1 and 0).
    """

    constraint: str
    subject: str
    other: str | None
    time: float
    value: float
    limit: float

    def __str__(self) -> str:
        pair = self.subject if self.other is None else f"{self.subject} - {self.other}"
        amount = f"{self.value:.3g} > {self.limit:.3g}"
        return f"{self.constraint}: {pair} at {self.time:.3f} s ({amount})"


@dataclass(frozen=True, eq=False)
class ParameterOverrides:
    """Masses (kg) and friction coefficients by object name, for one rollout."""

    masses: Mapping[str, float] = field(default_factory=dict)
    frictions: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Trace:
    """Recorded motion: ``times`` (t,), ``joints`` (t, dof), ``openings`` (t,), ``poses`` (t, n, 7).

    ``contacts`` (t, e, e), ascending pairs of entity numbers: what touched since the row before;
    None if the model does not record it.
    """

    times: Array
    joints: Array
    openings: Array
    poses: Array
    contacts: BoolArray | None = None


@dataclass(frozen=True, eq=False)
class RolloutResult:
    """The outcome of executing one motion.

    ``segment_states``: the state at the START of each executed segment, at ``segment_times`` (s).
    ``moved``: objects displaced by more than 1 cm. ``contacts``: pairs of names that touched.
    ``stalled``: the arm could not follow. ``continuation``: opaque, for models with the capability
    exact_continuation.
    ``lost``: why the engine gave no result (it crashed or hung); the rest then means nothing.
    ``outside_cpu``: CPU seconds spent in other processes; not part of the outcome.
    """

    final_state: SceneState
    violations: tuple[Violation, ...]
    moved: tuple[str, ...]
    contacts: frozenset[tuple[str, str]]
    stalled: bool
    duration: float
    steps: int
    segment_states: tuple[SceneState, ...] = ()
    segment_times: tuple[float, ...] = ()
    trace: Trace | None = None
    continuation: Any = None
    lost: str | None = None
    outside_cpu: float = 0.0

    @property
    def valid(self) -> bool:
        """The engine survived, no constraint is broken and the arm arrived."""
        return self.lost is None and not self.violations and not self.stalled


NO_CONTACTS: IntArray = np.zeros((0, 2), dtype=np.int64)
"""An observation without contacts."""

NO_DEPTHS: Array = np.zeros(0)
"""And their depths."""
