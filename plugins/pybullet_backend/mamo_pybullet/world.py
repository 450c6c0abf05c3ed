"""Builds the PyBullet world of a problem.

Exact: geometry, masses, friction cones, product friction between objects and with fixtures, the
object's own friction against the arm. Approximated: contacts are solved by up to ``iterations``
sweeps (sequential impulses), not exactly; friction against twisting is left out; immovable objects
are fixed bodies (touching one is a violation, so how it would move never matters); fingers touch
what they hold and press it no further, as sweeps let light things sink into them; an object is held
by a constraint between two bodies.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, Box, Shape
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides
from mamo_core.types.scene import Mobility, SceneState
from mamo_pybullet.bullet import pybullet, silenced
from mamo_pybullet.options import PyBulletOptions

GRAVITY = 9.81


@dataclass(frozen=True, eq=False)
class WorldIndex:
    """Where things are: ``objects``: body of each object; ``loose``: scene numbers of those that
    can move; ``entity``: entity number by body; ``arm`` and ``fingers``: joint numbers; ``moved``:
    all of them, ascending, as the engine's dynamics have them, with ``moved_arm`` and
    ``moved_fingers`` the places of the others there; ``tool``: the tool's link."""

    robot: int
    objects: tuple[int, ...]
    loose: tuple[int, ...]
    entity: dict[int, int]
    arm: tuple[int, ...]
    fingers: tuple[int, ...]
    moved: tuple[int, ...]
    moved_arm: list[int]
    moved_fingers: list[int]
    tool: int


@dataclass(frozen=True, eq=False)
class Bodies:
    """What the world is built from; ``masses`` (kg) and ``frictions`` of the objects."""

    problem: Problem
    arm: ArmModel
    options: PyBulletOptions
    masses: tuple[float, ...]
    frictions: tuple[float, ...]


def bodies_of(
    problem: Problem,
    arm: ArmModel,
    options: PyBulletOptions,
    parameters: ParameterOverrides | None,
) -> Bodies:
    """The problem's bodies with other masses and frictions where some are given.

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
    return Bodies(problem, arm, options, tuple(masses), tuple(frictions))


def build(bodies: Bodies, state: SceneState, client: int) -> WorldIndex:
    """Empty the client's world and build it with the objects where ``state`` says."""
    scene, options = bodies.problem.scene, bodies.options
    pybullet.resetSimulation(physicsClientId=client)
    pybullet.setGravity(0.0, 0.0, -GRAVITY, physicsClientId=client)
    pybullet.setPhysicsEngineParameter(
        fixedTimeStep=options.time_step,
        numSolverIterations=options.iterations,
        enableConeFriction=1,
        deterministicOverlappingPairs=1,
        physicsClientId=client,
    )
    robot = _add_arm(bodies, client)
    objects = tuple(_add_object(bodies, i, state.object_poses[i], client) for i in _all(scene))
    entity = {robot: 0, **{body: 1 + i for i, body in enumerate(objects)}}
    for fixture in scene.fixtures:
        body = _add_body(fixture.shape, fixture.pose, 0.0, fixture.friction, client)
        entity[body] = len(entity)
    loose = tuple(i for i in _all(scene) if scene.objects[i].mobility is not Mobility.IMMOVABLE)
    return _index(bodies.arm, robot, objects, loose, entity, client)


def _all(scene: Any) -> range:
    return range(len(scene.objects))


def _add_arm(bodies: Bodies, client: int) -> int:
    pose = bodies.problem.scene.T_world_base
    with silenced():  # it warns about a base without mass, which nobody can act on
        robot: int = pybullet.loadURDF(
            str(bodies.arm.urdf),
            basePosition=pose[:3].tolist(),
            baseOrientation=xyzw(pose),
            useFixedBase=1,
            flags=pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_SELF_COLLISION,
            physicsClientId=client,
        )
    for link in range(-1, pybullet.getNumJoints(robot, physicsClientId=client)):
        # Objects bring their own friction: the pair's coefficient is the product.
        pybullet.changeDynamics(
            robot,
            link,
            lateralFriction=1.0,
            jointDamping=0.0,
            linearDamping=0.0,
            angularDamping=0.0,
            physicsClientId=client,
        )
    _choose_own_pairs(bodies.arm, robot, client)
    return robot


def _choose_own_pairs(arm: ArmModel, robot: int, client: int) -> None:
    """Only the arm's ``hull_pairs`` are looked at of all pairs of the robot's own."""
    count = pybullet.getNumJoints(robot, physicsClientId=client)
    infos = [pybullet.getJointInfo(robot, j, physicsClientId=client) for j in range(count)]
    joint = {info[1].decode(): info[0] for info in infos}
    names = [*(link.name for link in arm.links), *(f"body_{part.name}" for part in arm.body)]
    chosen = {frozenset((joint[names[a]], joint[names[b]])) for a, b in arm.hull_pairs}
    for one in range(-1, count):
        for other in range(one + 1, count):
            meet = int(frozenset((one, other)) in chosen)
            pybullet.setCollisionFilterPair(robot, robot, one, other, meet, physicsClientId=client)


def _add_object(bodies: Bodies, place: int, pose: Array, client: int) -> int:
    item = bodies.problem.scene.objects[place]
    mass = 0.0 if item.mobility is Mobility.IMMOVABLE else bodies.masses[place]
    return _add_body(item.shape, pose, mass, bodies.frictions[place], client)


def _add_body(shape: Shape, pose: Array, mass: float, friction: float, client: int) -> int:
    """A rigid body; without mass it stands still."""
    if isinstance(shape, Box):
        form = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=(shape.size / 2.0).tolist(), physicsClientId=client
        )
    else:
        form = pybullet.createCollisionShape(
            pybullet.GEOM_CYLINDER,
            radius=shape.radius,
            height=shape.height,
            physicsClientId=client,
        )
    body: int = pybullet.createMultiBody(
        mass,
        form,
        basePosition=pose[:3].tolist(),
        baseOrientation=xyzw(pose),
        # A plain rigid body: faster, and the engine wakes it when something touches it.
        useMaximalCoordinates=1,
        physicsClientId=client,
    )
    pybullet.changeDynamics(
        body,
        -1,
        lateralFriction=friction,
        spinningFriction=0.0,
        rollingFriction=0.0,
        restitution=0.0,
        linearDamping=0.0,
        angularDamping=0.0,
        physicsClientId=client,
    )
    return body


def _index(
    arm: ArmModel,
    robot: int,
    objects: tuple[int, ...],
    loose: tuple[int, ...],
    entity: dict[int, int],
    client: int,
) -> WorldIndex:
    count = pybullet.getNumJoints(robot, physicsClientId=client)
    infos = [pybullet.getJointInfo(robot, j, physicsClientId=client) for j in range(count)]
    number = {info[1].decode(): info[0] for info in infos}
    chain = sorted((k for k in arm.links if k.coordinate >= 0), key=lambda link: link.coordinate)
    joints = tuple(number[link.name] for link in chain)
    fingers = tuple(number[link.name] for link in arm.links if link.coordinate < 0)
    moved = tuple(sorted((*joints, *fingers)))
    return WorldIndex(
        robot=robot,
        objects=objects,
        loose=loose,
        entity=entity,
        arm=joints,
        fingers=fingers,
        moved=moved,
        moved_arm=[moved.index(joint) for joint in joints],
        moved_fingers=[moved.index(joint) for joint in fingers],
        tool=number[arm.links[arm.tool_link].name],
    )


def xyzw(pose: Array) -> list[float]:
    """The quaternion of a pose (7,) in PyBullet's order."""
    w, x, y, z = pose[3:].tolist()
    return [x, y, z, w]
