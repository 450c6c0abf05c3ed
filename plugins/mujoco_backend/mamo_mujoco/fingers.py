"""Fingers that one motor moves together, with no more than the gripper's force."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from mamo_core.robots.fingers import finger_effort, finger_stiffness
from mamo_core.robots.model import ArmModel, LinkModel

_QUICK = 0.5
"""Steps in which the phase of a finger on its servo's spring advances, rad: beyond 2 it explodes."""


def add_finger_servo(spec: Any, link: LinkModel, arm: ArmModel, time_step: float) -> None:
    """A critically damped servo that yields at the gripper's force.

    The joint gets the armature with which the step can follow that spring: fingers are light, what
    moves them is not.
    """
    stiffness = finger_stiffness(arm)
    armature = stiffness * (time_step / _QUICK) ** 2
    spec.joint(link.name).armature = armature
    damping = 2.0 * float(np.sqrt(stiffness * armature))
    add_servo(spec, link, stiffness, damping, finger_effort(arm))


def add_servo(spec: Any, link: LinkModel, kp: float, kv: float, limit: float) -> None:
    """A servo with force kp (u - q) - kv q', at most ``limit``."""
    servo = spec.add_actuator(name=link.name, target=link.name)
    servo.trntype = mujoco.mjtTrn.mjTRN_JOINT
    servo.gainprm[0] = kp
    servo.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    servo.biasprm[1], servo.biasprm[2] = -kp, -kv
    servo.forcerange = [-limit, limit]
    servo.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE


def couple_fingers(spec: Any, arm: ArmModel, solref: list[float]) -> None:
    """All finger joints stand where the first one does."""
    names = [link.name for link in arm.links if link.coordinate < 0]
    for name in names[1:]:
        tie = spec.add_equality(name=f"fingers:{name}")
        tie.type = mujoco.mjtEq.mjEQ_JOINT
        tie.objtype = mujoco.mjtObj.mjOBJ_JOINT
        tie.name1, tie.name2 = name, names[0]
        tie.data[:5] = [0.0, 1.0, 0.0, 0.0, 0.0]
        tie.solref = solref


import os


class FrictionHold:
    """Makes a world's contacts what soft pads need while something is in the hand.

    Everything else happens as if it held things by welds, bit for bit.
    """

    def __init__(self, model: Any, geoms: Any) -> None:
        self._model, self._geoms = model, geoms
        self._place = -1

    def hold(self, place: int) -> None:
        """Object number ``place`` is in the hand from now on; -1: nothing."""
        model = self._model
        if self._place >= 0:
            geom = self._geoms[self._place]
            model.geom_condim[geom] = 3
        model.opt.impratio, model.opt.noslip_iterations = 1.0, 0
        self._place = place
        if place >= 0:
            geom = self._geoms[place]
            model.geom_condim[geom] = int(os.environ.get("DIM", "4"))
            model.geom_friction[geom, 1] = float(os.environ.get("R", "0.005")) * model.geom_friction[geom, 0]
            model.opt.impratio = float(os.environ.get("IMP", "1"))
            model.opt.noslip_iterations = int(os.environ.get("NOSLIP", "0"))
