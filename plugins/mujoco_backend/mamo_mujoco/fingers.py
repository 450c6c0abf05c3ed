"""Fingers that one motor moves together, with no more than the gripper's force."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from mamo_core.robots.fingers import finger_effort, finger_stiffness
from mamo_core.robots.model import ArmModel, LinkModel

_QUICK = 0.5
"""By so much the phase of a finger on its servo's spring advances in a step, rad: 2 explodes."""


_FINE, _NO_SLIP, _TWISTING, _STIFF = 0.001, 10, 4, 2.0
"""While friction holds something: largest step (s), iterations against creep, contact dimensions
(sliding and twisting), and the time constant of contacts in steps. The engine leaves out how
contacts turn with the bodies, so that what a turning hand holds slides by the square of its rate
times its distance from the axis times this constant: contacts are stiff, and steps short enough."""

PAD_RADIUS = 0.005
"""Lever of a pad's friction against twisting where it presses on a point, m: the mean distance from
the middle of a stripe as high as the pads of known grippers (2 cm)."""


def add_finger_servo(spec: Any, link: LinkModel, arm: ArmModel, time_step: float) -> None:
    """A critically damped servo that yields at the gripper's force.

    The joint gets the armature with which the step can follow that spring: fingers are light, what
    moves them is not.
    """
    stiffness = finger_stiffness(arm)
    joint = spec.joint(link.name)
    joint.armature = stiffness * (time_step / _QUICK) ** 2
    # Not of the servo, which has no damping left where it presses with all it has.
    joint.damping[0] = 2.0 * float(np.sqrt(stiffness * joint.armature))
    add_servo(spec, link, stiffness, 0.0, finger_effort(arm))


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


class FrictionHold:
    """Has fingers and friction hold things: a world's contacts become finer while they do.

    Meanwhile steps are short, what sticks does not creep (MuJoCo's friction alone gives way a
    little, as it is regularised), and pads resist twisting. Everything else happens as in a world
    that holds things by welds, bit for bit.
    """

    def __init__(self, model: Any, geoms: list[int]) -> None:
        """``geoms``: of the objects, in their order."""
        self._model, self._geoms = model, geoms
        self._step = float(model.opt.timestep)
        self._fine = int(np.ceil(self._step / _FINE - 1e-9))
        self._kept = {geom: self._contact(geom) for geom in geoms}

    def hold(self, place: int) -> int:
        """Object number ``place`` is in the hand from now on; -1: nothing.

        Returns into how many a step is divided.
        """
        model = self._model
        for geom, (dimensions, torsion, stiff) in self._kept.items():
            model.geom_condim[geom], model.geom_friction[geom, 1] = dimensions, torsion
            model.geom_solref[geom] = stiff
        substeps = 1 if place < 0 else self._fine
        model.opt.timestep = self._step / substeps
        model.opt.noslip_iterations = 0 if place < 0 else _NO_SLIP
        if place >= 0:
            geom = self._geoms[place]
            model.geom_condim[geom] = _TWISTING
            model.geom_friction[geom, 1] = PAD_RADIUS * model.geom_friction[geom, 0]
            model.geom_solref[geom, 0] = _STIFF * model.opt.timestep
        return substeps

    def _contact(self, geom: int) -> tuple[int, float, Any]:
        model = self._model
        stiff = model.geom_solref[geom].copy()
        return int(model.geom_condim[geom]), float(model.geom_friction[geom, 1]), stiff
