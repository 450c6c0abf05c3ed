"""Builds the DART world of a problem.

Exact: geometry, masses, joint servos (velocities are reached within one step), collision by ODE,
whose result depends on poses alone. Approximated: with ``contacts: cones`` friction cones are
circular and solved to a tolerance, with ``boxes`` they are square pyramids; between two objects the
coefficient is the smaller one, not the product, and fixtures that change friction are refused;
contacts are looked at every ``contacts_every`` steps; immovable objects are fixed bodies (touching
one is a violation, so how it would move never matters); fingers touch what they hold and press it
no further, as the solver lets light things sink into them; an object is held by a constraint
between two bodies.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import dartpy
import numpy as np

from mamo_core.robots.fingers import finger_drives
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, Box, IntArray, Shape, matrix_from_pose
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides
from mamo_core.types.scene import Mobility
from mamo_dart.options import DARTOptions

GRAVITY = 9.81

LINKAGE_LIMIT = 400.0
"""Of the linkage that keeps finger tips to their fingers, N m."""

NO_LIMIT = 1e6
"""Friction coefficient of arm and fixtures: the pair's is the smaller one, so the object's own."""

SLEEP_SPEED, SLEEP_SPIN, SLEEP_AFTER = 0.05, 0.2, 0.05
"""Bodies slower than this (m/s, rad/s) for this long (s) sleep until something touches them."""


BodyValues = tuple[list[float], list[float]]
"""Masses (kg) and friction coefficients of the objects."""


@dataclass(frozen=True, eq=False)
class DARTParts:
    """The world and where things are in it.

    ``loose``: body node by scene number of the objects that can move. ``arm`` (dof,), ``fingers``:
    places of the joints among the robot's coordinates. ``entity``: entity number by shape node.
    """

    world: Any
    robot: Any
    loose: dict[int, Any]
    arm: IntArray
    fingers: IntArray
    tool: Any
    entity: dict[Any, int]


def build(
    problem: Problem,
    arm: ArmModel,
    options: DARTOptions,
    values: BodyValues,
    robot: Any,
    poses: Array,
) -> DARTParts:
    """A new world of a problem around the robot, the objects at ``poses`` (n, 7)."""
    scene = problem.scene
    masses, frictions = values
    world = _empty_world(options)
    skeletons, loose = [robot], {}
    for place, item in enumerate(scene.objects):
        T = matrix_from_pose(poses[place])
        if item.mobility is Mobility.IMMOVABLE:
            skeletons.append(_fixed_body(item.name, item.shape, T, frictions[place]))
        else:
            body = _loose_body(item.name, item.shape, T, masses[place], frictions[place])
            skeletons.append(body)
            loose[place] = body.getBodyNode(0)
    for fixture in scene.fixtures:
        T = matrix_from_pose(fixture.pose)
        skeletons.append(_fixed_body(fixture.name, fixture.shape, T, NO_LIMIT))
    for skeleton in skeletons:
        world.addSkeleton(skeleton)
    _ignore_standing_pairs(world, skeletons)
    _choose_own_pairs(world, robot, arm)
    return DARTParts(
        world=world,
        robot=robot,
        loose=loose,
        arm=_coordinates(robot, [k.name for k in _in_order(arm)]),
        fingers=_coordinates(robot, [k.name for k in arm.links if k.coordinate < 0]),
        tool=robot.getJoint(arm.links[arm.tool_link].name).getChildBodyNode(),
        entity={node: n for n, skeleton in enumerate(skeletons) for node in _nodes(skeleton)},
    )


def _nodes(skeleton: Any) -> list[Any]:
    bodies = [skeleton.getBodyNode(k) for k in range(skeleton.getNumBodyNodes())]
    return [body.getShapeNode(k) for body in bodies for k in range(body.getNumShapeNodes())]


def _ignore_standing_pairs(world: Any, skeletons: list[Any]) -> None:
    """Bodies that never move need not be tested against each other."""
    standing = [skeleton.getBodyNode(0) for skeleton in skeletons if not skeleton.isMobile()]
    filtered = world.getConstraintSolver().getCollisionOption().collisionFilter
    for number, one in enumerate(standing):
        for other in standing[:number]:
            filtered.addBodyNodePairToBlackList(one, other)


def _choose_own_pairs(world: Any, robot: Any, arm: ArmModel) -> None:
    """Only the arm's ``hull_pairs`` are tested of all pairs of the robot's own."""
    joints = [*(link.name for link in arm.links), *(f"body_{part.name}" for part in arm.body)]
    chosen = {frozenset((joints[a], joints[b])) for a, b in arm.hull_pairs}
    bodies = [robot.getBodyNode(k) for k in range(robot.getNumBodyNodes())]
    filtered = world.getConstraintSolver().getCollisionOption().collisionFilter
    for number, one in enumerate(bodies):
        for other in bodies[:number]:
            names = frozenset((one.getParentJoint().getName(), other.getParentJoint().getName()))
            if names not in chosen:
                filtered.addBodyNodePairToBlackList(one, other)


def values_of(problem: Problem, parameters: ParameterOverrides | None) -> BodyValues:
    """Masses and frictions, others where some are given.

    Raises:
        KeyError: an override names no object.
    """
    scene = problem.scene
    masses = [item.mass for item in scene.objects]
    frictions = [item.friction for item in scene.objects]
    if parameters is not None:
        for name, mass in parameters.masses.items():
            masses[scene.index(name)] = mass
        for name, friction in parameters.frictions.items():
            frictions[scene.index(name)] = friction
    return masses, frictions


def _empty_world(options: DARTOptions) -> Any:
    world = dartpy.simulation.World()
    world.setTimeStep(options.time_step)
    world.setGravity([0.0, 0.0, -GRAVITY])
    sleep = world.getDeactivationOptions()
    sleep.mEnabled = options.sleep
    sleep.mLinearSpeedThreshold, sleep.mAngularSpeedThreshold = SLEEP_SPEED, SLEEP_SPIN
    sleep.mTimeUntilSleep = SLEEP_AFTER
    world.setDeactivationOptions(sleep)
    solver = world.getConstraintSolver()
    # Other detectors lose contacts (objects fall through), or depend on what ran before.
    solver.setCollisionDetector(dartpy.collision.OdeCollisionDetector())
    if options.contacts == "cones":
        cones = dartpy.constraint.NsgsFrictionSolver.Options()
        cones.maxSweeps, cones.tolerance = options.sweeps, options.tolerance
        solver.setBoxedLcpSolver(dartpy.constraint.NsgsFrictionSolver(cones))
    return world


def load_robot(problem: Problem, arm: ArmModel, options: DARTOptions) -> Any:
    """The arm's skeleton; reading its meshes is slow, and it holds no state but its joints'."""
    loader = dartpy.utils.DartLoader()
    settings = loader.getOptions()
    settings.mDefaultRootJointType = dartpy.utils.DartLoaderRootJointType.FIXED
    loader.setOptions(settings)
    robot = loader.parseSkeleton(str(arm.urdf))
    robot.setName(problem.scene.entities[0])
    robot.setSelfCollisionCheck(True)
    base = dartpy.math.Isometry3(matrix_from_pose(problem.scene.T_world_base))
    robot.getRootJoint().setTransformFromParentBodyNode(base)
    for number in range(robot.getNumBodyNodes()):
        body = robot.getBodyNode(number)
        body.setGravityMode(False)
        for k in range(body.getNumShapeNodes()):
            _rub(body.getShapeNode(k), NO_LIMIT)
    efforts = iter([finger.effort for finger in finger_drives(arm, LINKAGE_LIMIT)])
    for link in arm.links:
        joint = robot.getJoint(link.name)
        joint.setActuatorType(dartpy.dynamics.ActuatorType.SERVO)
        if link.coordinate < 0:
            limit = next(efforts)
        else:
            limit = options.effort * float(arm.effort[link.coordinate])
        joint.setForceLowerLimit(0, -limit)
        joint.setForceUpperLimit(0, limit)
    return robot


def _fixed_body(name: str, shape: Shape, T: Array, friction: float) -> Any:
    skeleton = dartpy.dynamics.Skeleton(name)
    joint, body = skeleton.createWeldJointAndBodyNodePair()
    _give_shape(body, shape, friction)
    joint.setTransformFromParentBodyNode(dartpy.math.Isometry3(T))
    # Otherwise everything on a board would be solved as one group.
    skeleton.setMobile(False)
    return skeleton


def _loose_body(name: str, shape: Shape, T: Array, mass: float, friction: float) -> Any:
    skeleton = dartpy.dynamics.Skeleton(name)
    joint, body = skeleton.createFreeJointAndBodyNodePair()
    form = _give_shape(body, shape, friction)
    body.setInertia(dartpy.dynamics.Inertia(mass, np.zeros(3), form.computeInertia(mass)))
    joint.setPositions(dartpy.dynamics.FreeJoint.convertToPositions(dartpy.math.Isometry3(T)))
    return skeleton


def _give_shape(body: Any, shape: Shape, friction: float) -> Any:
    if isinstance(shape, Box):
        form = dartpy.dynamics.BoxShape(shape.size)
    else:
        form = dartpy.dynamics.CylinderShape(shape.radius, shape.height)
    node = body.createShapeNode(form)
    node.createCollisionAspect()
    _rub(node, friction)
    return form


def _rub(node: Any, friction: float) -> None:
    aspect = node.getDynamicsAspect() or node.createDynamicsAspect()
    aspect.setFrictionCoeff(friction)
    aspect.setRestitutionCoeff(0.0)


def _in_order(arm: ArmModel) -> list[Any]:
    return sorted((k for k in arm.links if k.coordinate >= 0), key=lambda link: link.coordinate)


def _coordinates(robot: Any, joints: list[str]) -> IntArray:
    places = [robot.getJoint(name).getIndexInSkeleton(0) for name in joints]
    return np.array(places, dtype=np.int64)
