"""Where the tool is, and which configurations bring it somewhere."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from mamo_core.types.geometry import Array


@dataclass(frozen=True, eq=False)
class LineResult:
    """Configurations (k, dof) along a straight tool line and the ``fraction`` of it reached."""

    path: Array
    fraction: float


class Kinematics(ABC):
    """Kinematics of the arm of one problem; all poses are of the tool frame in the world."""

    @abstractmethod
    def forward(self, configuration: Array) -> Array:
        """``T_world_tool`` (4, 4) at a configuration (dof,)."""

    @abstractmethod
    def jacobian(self, configuration: Array) -> Array:
        """Geometric Jacobian (6, dof) of the tool origin: linear rows, then angular, world."""

    @abstractmethod
    def inverse(
        self,
        T_world_tool: Array,
        rng: np.random.Generator,
        *,
        count: int,
        near: Array | None = None,
    ) -> Array:
        """Up to ``count`` distinct configurations (k, dof) within joint limits, k may be 0.

        With ``near`` (dof,) that configuration seeds the first attempt.
        """

    @abstractmethod
    def follow_line(self, start: Array, T_world_end: Array, *, step: float = 0.01) -> LineResult:
        """Move the tool straight from ``start`` (dof,) to the pose, turning evenly.

        Stops where the line cannot be followed within joint limits and without a jump.
        """
