"""What a physics engine must be able to do; ``mamo_core.simulation`` does the rest."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from mamo_core.types.geometry import Array
from mamo_core.types.rollout import StepObservation, Watch
from mamo_core.types.scene import SceneState


class SimulatedWorld(ABC):
    """One engine's world of one problem, used by one thread at a time.

    Everything is a function of the last ``reset`` (or ``restore``) and of the commands since then.
    """

    exact_snapshots: ClassVar[bool] = False
    """Whether ``snapshot`` and ``restore`` continue bit for bit; otherwise motions are replayed."""

    squeeze: ClassVar[float] = 0.001
    """How much farther than the gap that an object leaves them fingers are sent to press it, m.

    An engine that welds what is held need only see that they touch. One that presses with the
    gripper's force sends them farther than it takes to reach that, so that an object that is a
    little narrower than it should be is pressed all the same.
    """

    pinch: float = 0.001
    """The same while the object is held: a weld needs no fingers, friction all of their force."""

    time_step: float
    """Simulated seconds of one ``step``."""

    @abstractmethod
    def reset(self, state: SceneState, drive: float) -> None:
        """Put everything where ``state`` says, at rest, the fingers at ``drive``, nothing held."""

    @abstractmethod
    def command(self, positions: Array, velocities: Array, drive: float) -> None:
        """Where the arm should be after the next step: (dof,) rad, rad/s; finger joints."""

    @abstractmethod
    def step(self) -> None:
        """Simulate ``time_step`` seconds."""

    @abstractmethod
    def observe(self, time: float, held: int) -> StepObservation:
        """What the constraints are shown; both arguments go into it as they are."""

    @abstractmethod
    def joint_positions(self) -> Array:
        """Arm joints (dof,), rad."""

    @abstractmethod
    def tool_pose(self) -> Array:
        """Pose (7,) of the tool link's frame, world."""

    @abstractmethod
    def object_poses(self) -> Array:
        """Poses (n, 7) of all objects, in the order of the scene; a new array."""

    @abstractmethod
    def at_rest(self, speed: float, spin: float) -> bool:
        """Whether every component of all velocities (m/s) and spins (rad/s) is below its bound."""

    @abstractmethod
    def hold(self, place: int) -> None:
        """Fix object number ``place`` to the tool link where it is now; -1 lets go."""

    def follow(
        self, positions: Array, velocities: Array, drives: Array, watch: Watch | None
    ) -> int:
        """Execute commands (k, dof), (k, dof), (k,) up to a step to look at; how many these are.

        That is at the latest the last one, or the first that the ``watch`` does not call harmless.
        To stop after each step, as here, is always right; an engine whose steps take hardly longer
        than looking at them may go on.
        """
        self.command(positions[0], velocities[0], float(drives[0]))
        self.step()
        return 1

    def wait(self, end: Array, steps: int, speed: float, spin: float, watch: Watch | None) -> int:
        """As ``follow``, at most ``steps`` without a command: the arm should be at ``end`` (dof,).

        A step after which the world is ``at_rest`` is looked at, too.
        """
        self.step()
        return 1

    def snapshot(self) -> Any:
        """The whole state, for ``restore`` in a world of the same problem; it can be pickled."""
        raise NotImplementedError(f"{type(self).__name__} has no snapshots")

    def restore(self, snapshot: Any) -> None:
        """Go on exactly where the snapshot was taken."""
        raise NotImplementedError(f"{type(self).__name__} has no snapshots")
