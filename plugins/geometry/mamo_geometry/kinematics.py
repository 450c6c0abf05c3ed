"""Kinematics of any serial arm by the compiled chain."""

from __future__ import annotations

import numpy as np

from mamo_core.interfaces.kinematics import Kinematics, LineResult
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, matrix_from_pose
from mamo_core.types.scene import Scene
from mamo_geometry.arrays import chain_arrays
from mamo_geometry.ik_kernels import fill_jacobian, inverse_batch, line_path, tool_frame
from mamo_geometry.options import KinematicsOptions


class ChainKinematics(Kinematics):
    """Damped least squares (Buss, 2004) with restarts from random configurations."""

    def __init__(self, scene: Scene, arm: ArmModel, options: KinematicsOptions) -> None:
        self._chain = chain_arrays(arm, matrix_from_pose(scene.T_world_base))
        self._home = np.array(arm.home)
        self._options = options
        # Beyond a full turn nothing new is found: sample near home there.
        self._low = np.maximum(arm.lower, self._home - np.pi)
        self._high = np.minimum(arm.upper, self._home + np.pi)

    def forward(self, configuration: Array) -> Array:
        T, _, _ = self._frames(configuration)
        return np.vstack([T, [0.0, 0.0, 0.0, 1.0]])

    def jacobian(self, configuration: Array) -> Array:
        T, R, p = self._frames(configuration)
        J = np.empty((6, self._home.size))
        fill_jacobian(self._chain, R, p, T, J)
        return J

    def inverse(
        self,
        T_world_tool: Array,
        rng: np.random.Generator,
        *,
        count: int,
        near: Array | None = None,
    ) -> Array:
        drawn = rng.uniform(
            self._low, self._high, (count * self._options.attempts, self._home.size)
        )
        seeds = drawn if near is None else np.vstack([near[None, :], drawn])
        goal = np.ascontiguousarray(T_world_tool[:3], dtype=np.float64)
        found = np.empty((count, self._home.size))
        apart = self._options.apart
        return found[: inverse_batch(self._chain, goal, seeds, self._home, apart, found)]

    def follow_line(self, start: Array, T_world_end: Array, *, step: float = 0.01) -> LineResult:
        T = self.forward(start)
        length = float(np.linalg.norm(T_world_end[:3, 3] - T[:3, 3]))
        turn = np.arccos(np.clip((np.trace(T[:3, :3].T @ T_world_end[:3, :3]) - 1) / 2, -1, 1))
        steps = max(1, int(np.ceil(max(length / step, turn / 0.1))))
        goal = np.ascontiguousarray(T_world_end[:3], dtype=np.float64)
        path = np.empty((steps + 1, self._home.size))
        count = line_path(self._chain, np.array(start, dtype=np.float64), goal, path)
        return LineResult(path[:count], (count - 1) / steps)

    def _frames(self, configuration: Array) -> tuple[Array, Array, Array]:
        dof = self._home.size
        R, p, T = np.empty((dof, 3, 3)), np.empty((dof, 3)), np.empty((3, 4))
        tool_frame(self._chain, np.array(configuration, dtype=np.float64), R, p, T)
        return T, R, p
