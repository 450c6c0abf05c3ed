"""Where a pushed object goes, and how it turns, if nothing else is in its way (quasi-static)."""

from __future__ import annotations

import numpy as np

from mamo_core.types.geometry import Array, Box, Shape


def slid(shape: Shape, start: Array, contacts: Array, directions: Array, steps: Array) -> Array:
    """Poses (n, k, 3), as x, y and yaw, after pushes that went ``steps`` (k,) metres so far.

    ``start`` (3,): x, y and yaw before. Each of n pushes moves a point straight from
    ``contacts`` (n, 2) along a unit ``directions`` (n, 2), world, and the object's point there
    goes with it. Friction under the object resists as an ellipsoid of force and torque (Lynch and
    Mason, 1996), whose size does not matter: motion ends when the push does.
    """
    position = np.tile(start[:2], (len(contacts), 1))
    yaw = np.full(len(contacts), start[2])
    poses = np.empty((len(contacts), len(steps), 3))
    gyration = _gyration(shape)
    for k, length in enumerate(np.diff(steps, prepend=0.0)):
        lever = contacts + (steps[k] - length) * directions - position
        across = np.stack([-lever[:, 1], lever[:, 0]], axis=1)
        turn = (across * directions).sum(axis=1) / (gyration + (lever**2).sum(axis=1))
        position = position + length * (directions - turn[:, None] * across)
        yaw = yaw + length * turn
        poses[:, k, :2], poses[:, k, 2] = position, yaw
    return poses


def _gyration(shape: Shape) -> float:
    """Mean square distance (m^2) of the footprint's points from its centre."""
    if isinstance(shape, Box):
        return float((shape.size[:2] ** 2).sum()) / 12.0
    return shape.radius**2 / 2.0
