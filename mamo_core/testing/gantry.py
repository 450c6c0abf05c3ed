"""A robot whose kinematics are the identity, so that tests can write tool positions down."""

from __future__ import annotations

import numpy as np

from mamo_core.interfaces.kinematics import Kinematics, LineResult
from mamo_core.types.geometry import Array, tool_matrix

GANTRY = "gantry"
"""Name of the robot in scenes that are made for the fakes; no engine knows it."""


class GantryKinematics(Kinematics):
    """Four joints: the tool's x, y, z (m) and yaw (rad). It cannot pitch or roll."""

    def __init__(self, lower: Array | None = None, upper: Array | None = None) -> None:
        self._lower = np.array([-2.0, -2.0, 0.0, -np.pi]) if lower is None else lower
        self._upper = np.array([2.0, 2.0, 2.0, np.pi]) if upper is None else upper

    def forward(self, configuration: Array) -> Array:
        x, y, z, yaw = configuration
        return tool_matrix([x, y, z], yaw)

    def jacobian(self, configuration: Array) -> Array:
        J = np.zeros((6, 4))
        J[[0, 1, 2, 5], [0, 1, 2, 3]] = 1.0
        return J

    def inverse(
        self,
        T_world_tool: Array,
        rng: np.random.Generator,
        *,
        count: int,
        near: Array | None = None,
    ) -> Array:
        configuration = self._configuration(T_world_tool)
        within = (configuration >= self._lower).all() and (configuration <= self._upper).all()
        upright = T_world_tool[2, 2] > 1.0 - 1e-9
        found = within and upright and count > 0
        return configuration[None, :] if found else np.zeros((0, 4))

    def follow_line(self, start: Array, T_world_end: Array, *, step: float = 0.01) -> LineResult:
        end = self._configuration(T_world_end)
        turn = float(np.angle(np.exp(1j * (end[3] - start[3]))))
        change = np.array([*(end[:3] - start[:3]), turn])
        count = max(1, int(np.ceil(float(np.linalg.norm(change[:3])) / step - 1e-9)))
        fractions = np.linspace(0.0, 1.0, count + 1)
        path = start + fractions[:, None] * change
        inside = ((path >= self._lower) & (path <= self._upper)).all(axis=1)
        reached = int(np.argmin(inside)) if not inside.all() else count + 1
        last = max(reached - 1, 0)
        return LineResult(path[: last + 1], float(fractions[last]))

    def _configuration(self, T: Array) -> Array:
        return np.array([*T[:3, 3], np.arctan2(T[1, 0], T[0, 0])])


class UprightGantry(GantryKinematics):
    """The same, but it answers tilted tool poses with upright ones at the same place."""

    def inverse(
        self,
        T_world_tool: Array,
        rng: np.random.Generator,
        *,
        count: int,
        near: Array | None = None,
    ) -> Array:
        upright = tool_matrix(T_world_tool[:3, 3], float(np.arctan2(*T_world_tool[1::-1, 0])))
        return super().inverse(upright, rng, count=count, near=near)
