"""Puts what an engine does on a time grid that does not depend on the engine."""

from __future__ import annotations

import numpy as np

from mamo_core.types.geometry import Array, BoolArray, IntArray
from mamo_core.types.rollout import NO_CONTACTS, Trace

_EPSILON = 1e-9


class TraceRecorder:
    """Shown every step, it keeps the motion at 0, ``step``, 2 ``step``, ... seconds.

    Between two steps positions are interpolated linearly and quaternions renormalised.
    ``entities``: how many there are in the scene, the robot and the fixtures included.
    """

    def __init__(self, step: float, entities: int) -> None:
        self._step = step
        self._rows: list[Array] = []
        self._times: list[float] = []
        self._before: tuple[float, Array] | None = None
        self._shape = (0, 0)
        self._touching = np.zeros((entities, entities), dtype=np.bool_)
        self._contacts: list[BoolArray] = []

    def see(
        self,
        time: float,
        joints: Array,
        opening: float,
        poses: Array,
        contacts: IntArray = NO_CONTACTS,
    ) -> None:
        """One step: ``joints`` (dof,), ``opening`` m, ``poses`` (n, 7), ``contacts`` (k, 2)."""
        self._shape = (joints.size, len(poses))
        now = np.concatenate([joints, [opening], poses.ravel()])
        self._touching[contacts[:, 0], contacts[:, 1]] = True
        while len(self._times) * self._step <= time + _EPSILON:
            wanted = len(self._times) * self._step
            self._times.append(wanted)
            self._rows.append(self._between(wanted, time, now))
            self._contacts.append(self._touching)
            self._touching = np.zeros_like(self._touching)
        self._before = (time, now)

    def _between(self, wanted: float, time: float, now: Array) -> Array:
        if self._before is None or time - self._before[0] < _EPSILON:
            return now
        share = (wanted - self._before[0]) / (time - self._before[0])
        mixed: Array = self._before[1] + share * (now - self._before[1])
        return mixed

    def trace(self) -> Trace:
        """What was kept so far."""
        dof, count = self._shape
        rows = np.array(self._rows).reshape(len(self._times), dof + 1 + 7 * count)
        poses = rows[:, dof + 1 :].reshape(-1, count, 7).copy()
        poses[:, :, 3:] /= np.linalg.norm(poses[:, :, 3:], axis=2, keepdims=True)
        contacts = np.array(self._contacts)
        return Trace(np.array(self._times), rows[:, :dof], rows[:, dof], poses, contacts)
