"""Builds the MuJoCo world of a problem.

Exact: geometry, masses, elliptic friction cones, product friction between objects and with
fixtures, the object's own friction against the arm. Approximated: contacts are soft, so that what
presses hard sinks in a little; immovable objects are fixed bodies (touching one is a violation, so
how it would move never matters, nor that the larger coefficient counts there); fingers that one
motor moves are kept together by constraints of their joints; an object is held by a weld, or by the
fingers and friction alone (``grasp``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from mamo_core.robots.model import ArmModel, LinkModel
from mamo_core.types.geometry import Array, Box, IntArray, Shape, matrix_from_pose, pose_from_matrix
from mamo_core.types.problem import Problem
from mamo_core.types.scene import Mobility
from mamo_mujoco.clearance import add_immovable_pairs, keep_clear
from mamo_mujoco.fingers import add_finger_servo, add_servo, couple_fingers
from mamo_mujoco.options import MuJoCoOptions
from mamo_mujoco.own_contacts import add_body, add_own_pairs

_ROBOT, _OBJECT, _FIXTURE = 1, 2, 4
_COLLIDES_WITH = {
    _ROBOT: _OBJECT | _FIXTURE,
    _OBJECT: _ROBOT | _OBJECT | _FIXTURE,
    _FIXTURE: _ROBOT | _OBJECT,
}
_ARMATURE = 0.1
"""Of every joint, kg m^2. With less, what is welded to the hand shakes: contact and weld forces are
computed before the servos' damping, which is implicit, and expect light joints to jump."""
_TORSION, _ROLLING = 0.005, 0.0001


@dataclass(frozen=True, eq=False)
class WorldIndex:
    """Where things are in the compiled model.

    ``arm_qpos``, ``arm_qvel`` (dof,), ``finger_qpos``, ``finger_qvel``; ``free`` (m,): scene
    numbers of objects that can move, with ``free_qpos``, ``free_qvel`` (m,) their first
    coordinates; ``bodies`` (n,): body of every object; ``entity`` (geoms,): entity number;
    ``free_trees`` (m,): kinematic trees of objects that can move; ``welds`` (n,): the equality that
    holds each object, or -1.
    """

    arm_qpos: IntArray
    arm_qvel: IntArray
    finger_qpos: IntArray
    finger_qvel: IntArray
    free: IntArray
    free_qpos: IntArray
    free_qvel: IntArray
    bodies: IntArray
    entity: IntArray
    tool_body: int
    free_trees: IntArray
    welds: IntArray


def build_model(
    problem: Problem, arm: ArmModel, options: MuJoCoOptions, clearance: float = 0.0
) -> Any:
    """Compile the ``MjModel`` of a problem; ``clearance`` (m): as in ``ContactConstraint``."""
    spec = mujoco.MjSpec()
    spec.option.timestep = options.time_step
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    spec.option.tolerance = options.tolerance
    if options.sleep:
        spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
    _add_arm(spec, problem, arm, options)
    couple_fingers(spec, arm, _solref(options))
    for fixture in problem.scene.fixtures:
        body = spec.worldbody.add_body(name=fixture.name, **_frame(matrix_from_pose(fixture.pose)))
        _add_shape(body, fixture.name, fixture.shape, _FIXTURE, fixture.friction, options)
    for item, pose in zip(problem.scene.objects, problem.initial.object_poses, strict=True):
        body = spec.worldbody.add_body(name=item.name, **_frame(matrix_from_pose(pose)))
        geom = _add_shape(body, item.name, item.shape, _OBJECT, item.friction, options)
        geom.mass = item.mass
        if item.mobility is not Mobility.IMMOVABLE:
            body.add_freejoint(name=item.name)
    _add_friction_pairs(spec, problem, options)
    if options.grasp == "weld":
        _add_weld(spec, problem, arm, options)
    if not options.arm_meets_fixtures:
        _part_arm_and_fixtures(spec)
    if clearance == 0.0:
        return spec.compile()
    add_immovable_pairs(spec, problem, _solref(options))
    model = spec.compile()
    keep_clear(model, problem, clearance)
    return model


def index_of(model: Any, problem: Problem, arm: ArmModel) -> WorldIndex:
    """Find the arm, the objects and the geoms of a compiled model."""
    names = [link.name for link in sorted(_arm_links(arm), key=lambda link: link.coordinate)]
    fingers = [link.name for link in arm.links if link.coordinate < 0]
    free = [i for i, o in enumerate(problem.scene.objects) if o.mobility is not Mobility.IMMOVABLE]
    free_names = [problem.scene.objects[i].name for i in free]
    number = {name: i for i, name in enumerate(problem.scene.entities)}
    entity = [number.get(model.geom(g).name, 0) for g in range(model.ngeom)]
    return WorldIndex(
        arm_qpos=_addresses(model, names, "jnt_qposadr"),
        arm_qvel=_addresses(model, names, "jnt_dofadr"),
        finger_qpos=_addresses(model, fingers, "jnt_qposadr"),
        finger_qvel=_addresses(model, fingers, "jnt_dofadr"),
        free=np.array(free, dtype=np.int64),
        free_qpos=_addresses(model, free_names, "jnt_qposadr"),
        free_qvel=_addresses(model, free_names, "jnt_dofadr"),
        bodies=np.array([model.body(o.name).id for o in problem.scene.objects], dtype=np.int64),
        entity=np.array(entity, dtype=np.int64),
        tool_body=model.body(f"link:{arm.links[arm.tool_link].name}").id,
        free_trees=np.array(
            [model.body_treeid[model.body(name).id] for name in free_names], dtype=np.int64
        ),
        welds=np.array([_weld_of(model, o.name) for o in problem.scene.objects], dtype=np.int64),
    )


def _weld_of(model: Any, name: str) -> int:
    number: int = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_EQUALITY, f"hold:{name}")
    return number


def _arm_links(arm: ArmModel) -> list[LinkModel]:
    return [link for link in arm.links if link.coordinate >= 0]


def _addresses(model: Any, joints: list[str], field: str) -> IntArray:
    table = getattr(model, field)
    return np.array([table[model.joint(name).id] for name in joints], dtype=np.int64)


def _frame(T: Array) -> dict[str, Array]:
    pose = pose_from_matrix(T)
    return {"pos": pose[:3], "quat": pose[3:]}


def _solref(options: MuJoCoOptions) -> list[float]:
    """Contacts as stiff as the step allows; the default of 20 ms is soft."""
    return [2.5 * options.time_step, 1.0]


def _add_arm(spec: Any, problem: Problem, arm: ArmModel, options: MuJoCoOptions) -> None:
    base = spec.worldbody.add_body(
        name="robot:base", **_frame(matrix_from_pose(problem.scene.T_world_base))
    )
    bodies: list[Any] = []
    for link in arm.links:
        parent = base if link.parent < 0 else bodies[link.parent]
        bodies.append(_add_link(spec, parent, link, options))
        if link.coordinate >= 0:
            _add_servo(spec, arm, link, options)
        else:
            add_finger_servo(spec, link, arm, options.time_step)
    add_body(spec, base, arm)
    add_own_pairs(spec, arm)


def _add_link(spec: Any, parent: Any, link: LinkModel, options: MuJoCoOptions) -> Any:
    i = link.inertia
    body = parent.add_body(
        name=f"link:{link.name}",
        gravcomp=1.0,
        explicitinertial=True,
        mass=link.mass,
        ipos=link.center_of_mass,
        # Left unset, iquat and ipos would come from the frame and throw the scene apart.
        iquat=[1.0, 0.0, 0.0, 0.0],
        fullinertia=[i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]],
        **_frame(link.T_parent_joint),
    )
    kind = mujoco.mjtJoint.mjJNT_SLIDE if link.prismatic else mujoco.mjtJoint.mjJNT_HINGE
    body.add_joint(name=link.name, type=kind, axis=link.axis, armature=_ARMATURE)
    for k, hull in enumerate(link.hulls):
        name = f"{link.name}:{k}"
        spec.add_mesh(name=name, file=str(hull))
        body.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=name,
            contype=_ROBOT,
            conaffinity=_COLLIDES_WITH[_ROBOT],
            mass=0.0,
            solref=_solref(options),
        )
    return body


def _add_servo(spec: Any, arm: ArmModel, link: LinkModel, options: MuJoCoOptions) -> None:
    """A servo with force kp (u - q) - kv q'; u = q_ref + kv / kp q'_ref makes it track.

    It gives no more than the joint's effort, and is so stiff that an error of ``give`` asks for it.
    """
    strength = float(arm.effort[link.coordinate])
    kp, limit = min(options.stiffness, strength / options.give), options.effort * strength
    add_servo(spec, link, kp, options.lead * kp, limit)


def _add_shape(
    body: Any, name: str, shape: Shape, kind: int, friction: float, options: MuJoCoOptions
) -> Any:
    if isinstance(shape, Box):
        geometry, size = mujoco.mjtGeom.mjGEOM_BOX, shape.size / 2.0
    else:
        geometry = mujoco.mjtGeom.mjGEOM_CYLINDER
        size = np.array([shape.radius, shape.height / 2.0, 0.0])
    return body.add_geom(
        name=name,
        type=geometry,
        size=size,
        contype=kind,
        conaffinity=_COLLIDES_WITH[kind],
        # The higher priority decides: objects bring their own friction to arm and fixtures.
        priority=1 if kind == _OBJECT else 0,
        friction=[friction, _TORSION, _ROLLING],
        solref=_solref(options),
    )


def _add_friction_pairs(spec: Any, problem: Problem, options: MuJoCoOptions) -> None:
    """Between two objects MuJoCo would take the larger coefficient; the rule is the product.

    Fixtures need it only where their factor is not 1: the object's own coefficient decides there.
    """
    loose = [
        (o.name, o.friction) for o in problem.scene.objects if o.mobility is not Mobility.IMMOVABLE
    ]
    fixtures = [(f.name, f.friction) for f in problem.scene.fixtures if f.friction != 1.0]
    for i, (one, of_one) in enumerate(loose):
        for other, of_other in (*loose[i + 1 :], *fixtures):
            mu = of_one * of_other
            spec.add_pair(
                name=f"{one}|{other}",
                geomname1=one,
                geomname2=other,
                condim=3,
                friction=[mu, mu, _TORSION, _ROLLING, _ROLLING],
                solref=_solref(options),
            )


def _part_arm_and_fixtures(spec: Any) -> None:
    """They do not collide, only each with objects."""
    for geom in spec.geoms:
        if geom.contype in (_ROBOT, _FIXTURE):
            geom.conaffinity = _OBJECT


def _add_weld(spec: Any, problem: Problem, arm: ArmModel, options: MuJoCoOptions) -> None:
    for item in problem.scene.objects:
        if item.mobility is Mobility.IMMOVABLE:
            continue
        weld = spec.add_equality(name=f"hold:{item.name}", active=False)
        weld.type = mujoco.mjtEq.mjEQ_WELD
        weld.objtype = mujoco.mjtObj.mjOBJ_BODY
        weld.name1 = f"link:{arm.links[arm.tool_link].name}"
        weld.name2 = item.name
        weld.data[10] = 1.0
        weld.solref = _solref(options)
