"""Whether robots collide with themselves: what the spheres miss, what plans do, and the speed.

    python benchmarks/self_collisions.py [PLANS...]

Of random configurations (seeded, no objects, no fixtures) that the spheres call free, how many
collide on the exact meshes, and of those that are free on the meshes, how many the spheres refuse.
Of plan files, those that collide with themselves anywhere on the way. Checks per CPU second.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from mamo_geometry.options import SphereCheckerOptions
from mamo_geometry.sphere_checker import SphereChecker
from mamo_mujoco.model import MuJoCoModel
from mamo_mujoco.options import MuJoCoOptions

from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.plan_file import read_plan
from mamo_core.robots import ArmModel, load_arm
from mamo_core.robots.self_collision import SelfCollisions, check_self_collisions
from mamo_core.robots.specs import SPECS
from mamo_core.types.geometry import Array, Box, make_pose
from mamo_core.types.motion import Motion
from mamo_core.types.scene import Mobility, Scene, SceneObject, Workspace

COUNT = 1_000
BATCH, REPEATS = 20_000, 5


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; the exit code is 1 if anything collides."""
    made = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    made.add_argument("plans", nargs="*", type=Path)
    options = made.parse_args(arguments)
    missed = sum(random_configurations(load_arm(name)) for name in sorted(SPECS))
    colliding = [path for path in options.plans if plan_collides(path)]
    if options.plans:
        print(f"{len(colliding)} of {len(options.plans)} plans collide with themselves")
    return int(bool(missed or colliding))


def random_configurations(arm: ArmModel) -> int:
    """Print figures of one robot; how many collisions the spheres miss."""
    rng, missed, refused, free = np.random.default_rng(0), 0, 0, 0
    for opening in (arm.gripper.closed, arm.gripper.max_opening):
        world, exact = empty_world(arm, opening), SelfCollisions(arm)
        called = drawn(arm, world, COUNT // 2, rng)
        missed += int((~exact.free(called, opening)).sum())
        anywhere = sample(arm, COUNT // 2, rng)
        really = exact.free(anywhere, opening)
        free += int(really.sum())
        refused += int((really & ~world.free(anywhere)).sum())
    print(
        f"{arm.name}: {missed} of {COUNT} that the spheres call free collide on the meshes; "
        f"{refused} of {free} free of {COUNT} are refused; {speed(arm):,.0f} checks/s"
    )
    return missed


def empty_world(arm: ArmModel, opening: float) -> CollisionWorld:
    """The robot alone: the target that a scene must have is far away."""
    target = SceneObject("target", Box(np.full(3, 0.05)), Mobility.TARGET, 0.1, 1.0)
    space = Workspace(np.array([9.0, -0.5, 0.0]), np.array([10.0, 0.5, 1.0]))
    scene = Scene(arm.name, make_pose([0.0, 0.0, 0.0]), (), (target,), space)
    checker = SphereChecker(scene, arm, SphereCheckerOptions())
    return checker.world(np.array([make_pose([9.5, 0.0, 0.0])]), opening=opening)


def sample(arm: ArmModel, count: int, rng: np.random.Generator) -> Array:
    """Configurations (count, dof) anywhere."""
    low, high = arm.around_home
    return rng.uniform(low, high, (count, arm.dof))


def drawn(arm: ArmModel, world: CollisionWorld, count: int, rng: np.random.Generator) -> Array:
    """Configurations (count, dof) that the spheres call free."""
    rows = np.empty((0, arm.dof))
    while len(rows) < count:
        more = sample(arm, count, rng)
        rows = np.vstack([rows, more[world.free(more)]])
    return rows[:count]


def speed(arm: ArmModel) -> float:
    """Checks of random configurations in a CPU second."""
    world = empty_world(arm, arm.gripper.max_opening)
    rows = sample(arm, BATCH, np.random.default_rng(1))
    world.free(rows)
    begin = time.process_time()
    for _ in range(REPEATS):
        world.free(rows)
    return REPEATS * BATCH / (time.process_time() - begin)


def plan_collides(path: Path) -> bool:
    """Print where a plan collides with itself; the objects are where MuJoCo leaves them."""
    document = read_plan(path)
    problem, plan = document.problem, document.plan
    robot = load_arm(problem.scene.robot)
    model = MuJoCoModel(problem, robot, (), MuJoCoOptions())
    segments = tuple(s for motion in plan.motions for s in motion.segments)
    whole = Motion(segments, plan.motions[0].opening)
    rollout = model.rollout(problem.initial, whole, options=RolloutOptions(stop_early=False))
    before = plan.motions[0].opening
    found = check_self_collisions(
        problem.scene,
        segments[: len(rollout.segment_states)],
        rollout.segment_states,
        robot,
        before,
    )
    for text in found:
        print(f"{path}: {text}")
    return bool(found)


if __name__ == "__main__":
    raise SystemExit(main())
