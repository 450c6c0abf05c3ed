"""Kinematics of any serial arm by the compiled chain."""

from __future__ import annotations

import math

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
        self._low, high = arm.around_home
        self._range = high - self._low

    def forward(self, configuration: Array) -> Array:
        T = np.zeros((4, 4))
        T[3, 3] = 1.0
        self._frames(configuration, T[:3])
        return T

    def jacobian(self, configuration: Array) -> Array:
        T = np.empty((3, 4))
        R, p = self._frames(configuration, T)
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
        drawn = rng.random((count * self._options.attempts, self._home.size))
        drawn = self._low + self._range * drawn
        seeds = drawn
        if near is not None:
            inside = np.clip(near, self._chain.lower, self._chain.upper)
            seeds = np.vstack([inside[None, :], drawn])
        goal = np.ascontiguousarray(T_world_tool[:3], dtype=np.float64)
        found = np.empty((count, self._home.size))
        apart = self._options.apart
        return found[: inverse_batch(self._chain, goal, seeds, self._home, apart, found)]

    def follow_line(self, start: Array, T_world_end: Array, *, step: float = 0.01) -> LineResult:
        T = np.empty((3, 4))
        self._frames(start, T)
        offset = T_world_end[:3, 3] - T[:, 3]
        length = math.sqrt(offset.dot(offset))
        cosine = ((T[:, :3].T @ T_world_end[:3, :3]).trace() - 1) / 2
        turn = np.arccos(min(max(cosine, -1.0), 1.0))
        steps = max(1, int(np.ceil(max(length / step, turn / 0.1))))
        goal = np.ascontiguousarray(T_world_end[:3], dtype=np.float64)
        path = np.empty((steps + 1, self._home.size))
        count = line_path(self._chain, np.array(start, dtype=np.float64), goal, path)
        return LineResult(path[:count], (count - 1) / steps)

    def _frames(self, configuration: Array, T: Array) -> tuple[Array, Array]:
        """Fills the tool frame ``T`` (3, 4); rotations (dof, 3, 3) and origins of the links."""
        dof = self._home.size
        R, p = np.empty((dof, 3, 3)), np.empty((dof, 3))
        tool_frame(self._chain, np.array(configuration, dtype=np.float64), R, p, T)
        return R, p
