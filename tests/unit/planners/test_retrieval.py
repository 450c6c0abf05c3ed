"""Retrievals: by which grasp, how, and if not, why not."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from mamo_planners.options import RetrievalOptions
from mamo_planners.retrieval import GraspAndExtract

from mamo_core.interfaces.collision_checker import HeldObject
from mamo_core.robots.exact_collision import ExactChecker
from mamo_core.robots.grasps import widths_between_fingers
from mamo_core.robots.timing import interpolated
from mamo_core.types.geometry import Box, Cylinder, invert, make_pose, matrix_from_pose
from mamo_core.types.problem import Grasp
from mamo_core.types.scene import Mobility, SceneState


def retrieval_of(problem, parts, **options):
    return GraspAndExtract(
        problem,
        parts.arm,
        parts.kinematics,
        parts.collision,
        parts.arm_planner,
        RetrievalOptions(**options),
    )


@pytest.fixture(scope="module")
def retrieval(problem, parts):
    return retrieval_of(problem, parts)


@pytest.fixture(scope="module")
def cleared(problem):
    """The blocker is out of the way."""
    poses = np.array(problem.initial.object_poses)
    poses[0, :2] = 0.9, -0.5
    return SceneState(problem.home, poses)


@pytest.fixture(scope="module")
def found(retrieval, cleared):
    result = retrieval.plan(cleared, np.random.default_rng(0))
    assert result.motion is not None, result.causes
    return result


def in_the_hand(problem, parts, motion):
    """``T_tool_target`` (4, 4) while it is held."""
    lift = next(s for s in motion.segments if s.held is not None)
    T_world_tool = parts.kinematics.forward(lift.trajectory.positions[0])
    target = problem.initial.object_poses[problem.scene.target_index]
    return invert(T_world_tool) @ matrix_from_pose(target)


def test_the_motion(problem, parts, found):
    motion = found.motion
    kinds = [s.kind.value for s in motion.segments]
    assert kinds == ["gripper", "transit", "reach", "gripper", "lift", "carry"]
    assert [s.held for s in motion.segments] == [None, None, None, None, "target", "target"]
    assert [s.closes_on for s in motion.segments] == [None, None, None, "target", None, None]
    assert all(s.contact_free for s in motion.segments)
    assert np.array_equal(motion.start, problem.home)
    np.testing.assert_allclose(motion.end, problem.home, atol=1e-8)
    assert motion.opening == parts.arm.gripper.closed
    grasp = problem.grasps[found.grasp]
    target = problem.scene.objects[problem.scene.target_index]
    T_object_tool = matrix_from_pose(grasp.T_object_tool)
    width = float(widths_between_fingers(target.shape, T_object_tool[None])[0])
    assert [s.opening for s in motion.segments] == [grasp.opening] * 3 + [width] * 3
    limits = parts.arm.velocity
    for segment in motion.segments:
        t = segment.trajectory
        assert (np.abs(np.diff(t.positions, axis=0)) <= np.diff(t.times)[:, None] * limits).all()
        assert (t.positions >= parts.arm.lower - 1e-9).all()
        assert (t.positions <= parts.arm.upper + 1e-9).all()


def test_the_tool_is_at_the_grasp_when_it_takes_hold(problem, parts, found):
    grasp = problem.grasps[found.grasp]
    reach, lift = (s for s in found.motion.segments if s.kind in ("reach", "lift"))
    T_world_tool = parts.kinematics.forward(reach.trajectory.positions[-1])
    T_world_object = matrix_from_pose(problem.initial.object_poses[problem.scene.target_index])
    expected = T_world_object @ matrix_from_pose(grasp.T_object_tool)
    np.testing.assert_allclose(T_world_tool, expected, atol=3e-4)
    start = parts.kinematics.forward(reach.trajectory.positions[0])
    np.testing.assert_allclose(
        start[:3, 3], expected[:3, 3] - grasp.approach * expected[:3, 0], atol=1e-3
    )
    top = parts.kinematics.forward(lift.trajectory.positions[-1])
    rise = top[2, 3] - T_world_tool[2, 3]
    assert 0.02 < rise <= 0.075 + 1e-4
    np.testing.assert_allclose(top[:2, 3], T_world_tool[:2, 3], atol=1e-3)


def test_exact_meshes_touch_nothing(problem, parts, cleared, found):
    exact = ExactChecker(problem.scene, parts.arm)
    for segment in found.motion.segments:
        ignore = [name for name in (segment.held, segment.closes_on) if name is not None]
        world = exact.world(cleared.object_poses, opening=segment.opening, ignore=ignore)
        for q in interpolated(segment.trajectory.positions, 0.05):
            assert world.first_touched(q) is None, segment.kind


def test_the_target_stays_upright(problem, parts, found):
    for segment in found.motion.segments:
        if segment.held is None:
            continue
        for q in interpolated(segment.trajectory.positions, 0.02):
            up = parts.kinematics.forward(q)[2, 2]
            assert up >= np.cos(np.radians(18.0)) - 1e-3


def test_the_held_target_touches_nothing(problem, parts, cleared, found):
    """Carried past everything, with the exact solid."""
    carry = found.motion.segments[-1]
    item = problem.scene.objects[problem.scene.target_index]
    held = HeldObject(item.name, item.shape, in_the_hand(problem, parts, found.motion))
    world = ExactChecker(problem.scene, parts.arm).world(
        cleared.object_poses, opening=carry.opening, ignore=[item.name], held=held
    )
    rows = interpolated(carry.trajectory.positions, 0.05)
    assert len(rows) > 10
    assert [world.first_touched(q) for q in rows] == [None] * len(rows)


def test_a_blocked_target_is_not_retrieved(problem, retrieval):
    blocked = retrieval.plan(problem.initial, np.random.default_rng(0))
    assert blocked.motion is None
    assert blocked.causes
    assert all(times > 0 for times in blocked.causes.values())


def test_without_movables_it_goes_through_the_blocker(problem, retrieval):
    through = retrieval.plan(problem.initial, np.random.default_rng(0), ignore_movables=True)
    assert through.motion is not None
    region = retrieval.swept_region(problem.initial, through.motion)
    shape = problem.scene.objects[0].shape
    assert region.overlaps(shape, problem.initial.object_poses[0])
    assert not region.overlaps(problem.scene.objects[1].shape, problem.initial.object_poses[1])


def test_the_region_holds_the_target_on_its_way(problem, parts, retrieval, found):
    region = retrieval.swept_region(problem.initial, found.motion)
    T_tool_target = in_the_hand(problem, parts, found.motion)
    for segment in found.motion.segments[3:]:
        for q in segment.trajectory.positions[::3]:
            x, y, z = (parts.kinematics.forward(q) @ T_tool_target)[:3, 3]
            cell = np.floor((np.array([x, y]) - region.origin) / region.resolution).astype(int)
            if ((cell >= 0) & (cell < region.lowest.shape)).all():
                assert region.lowest[tuple(cell)] <= z - 0.06


def test_the_region_is_that_of_all_segments(problem, retrieval, found):
    region = retrieval.swept_region(problem.initial, found.motion)
    for segment in found.motion.segments[:3]:
        part = retrieval._collision.swept_region(
            segment.trajectory.positions, opening=segment.opening
        )
        assert (region.lowest <= part.lowest).all()


def test_avoided_grasps_are_not_used(retrieval, cleared):
    used = set()
    for _ in range(4):
        result = retrieval.plan(cleared, np.random.default_rng(0), avoid=used)
        if result.motion is None:
            break
        assert result.grasp not in used
        used.add(result.grasp)
    assert len(used) >= 2


def test_nothing_left_when_all_are_avoided(problem, retrieval, cleared):
    everything = range(len(problem.grasps))
    assert retrieval.plan(cleared, np.random.default_rng(0), avoid=everything).motion is None


def test_same_seed_same_motion(retrieval, cleared):
    one, other = (retrieval.plan(cleared, np.random.default_rng(3)) for _ in range(2))
    assert one.grasp == other.grasp
    for a, b in zip(one.motion.segments, other.motion.segments, strict=True):
        assert np.array_equal(a.trajectory.positions, b.trajectory.positions)
        assert np.array_equal(a.trajectory.times, b.trajectory.times)


def causes(problem, parts_of, **options):
    retrieval = retrieval_of(problem, parts_of(problem), **options)
    result = retrieval.plan(problem.initial, np.random.default_rng(0), ignore_movables=True)
    assert result.motion is None
    return dict(result.causes)


def test_out_of_reach(shelf_with, parts_of):
    problem = shelf_with(T_world_base=make_pose([-2.0, 0.0, 0.0]))
    assert causes(problem, parts_of) == {"out_of_reach": len(problem.grasps)}


def test_gripper_too_small(problem, parts_of):
    wide = tuple(replace(grasp, opening=0.3) for grasp in problem.grasps)
    found = causes(replace(problem, grasps=wide), parts_of)
    assert found == {"gripper_too_small": len(wide)}


def test_no_grasps(problem, parts_of):
    assert causes(replace(problem, grasps=()), parts_of) == {}


def test_a_grasp_that_no_configuration_reaches(problem, parts_of):
    """From behind: within the length of the arm, but not like this."""
    backwards = Grasp(make_pose([0.0, 0.0, 0.0], np.pi), approach=0.1, opening=0.08)
    found = causes(replace(problem, grasps=(backwards,)), parts_of)
    assert set(found) <= {"grasp_no_ik", "grasp_in_collision", "reach_blocked"}
    assert sum(found.values()) >= 1


def test_walled_in_by_immovables(shelf_with, parts_of):
    wall = Box(np.array([0.04, 0.5, 0.25]))
    problem = shelf_with({"post": (wall, Mobility.IMMOVABLE, (0.6, -0.5))})
    found = causes(problem, parts_of)
    assert {"hand_blocked", "grasp_in_collision", "reach_blocked"} & set(found)
    assert not {"out_of_reach", "gripper_too_small"} & set(found)


def test_a_tall_target_is_lifted_less(shelf_with, parts_of):
    """Under the ceiling a gap stays: 25 cm of 32 leave 7, of which 1.5 remain."""
    problem = shelf_with({"target": (Cylinder(0.03, 0.27), Mobility.TARGET, (0.7, -0.5))})
    parts = parts_of(problem)
    retrieval = retrieval_of(problem, parts)
    ceiling = problem.scene.workspace.upper[2]
    assert retrieval._grasps.found
    for candidate in retrieval._grasps.found:
        rise = (
            parts.kinematics.forward(candidate.lift[-1])[2, 3]
            - parts.kinematics.forward(candidate.lift[0])[2, 3]
        )
        top = problem.scene.workspace.floor + 0.27 + rise
        assert top <= ceiling - 0.015 + 1e-3
        assert rise > 0.0


class Squeamish:
    """Refuses whatever has the tool in a narrow band before the target, as coarse covers might."""

    BAND = (0.69, 0.712)

    def __init__(self, parts):
        self._parts = parts

    def world(self, *arguments, **options):
        world = self._parts.collision.world(*arguments, **options)
        refusing = SimpleNamespace(hands_free=world.hands_free)
        refusing.free = lambda rows: world.free(rows) & ~self.in_band(np.atleast_2d(rows))
        return refusing

    def in_band(self, rows):
        places = [self._parts.kinematics.forward(q)[0, 3] for q in rows]
        return np.array([self.BAND[0] < x < self.BAND[1] for x in places])


def test_the_meshes_decide_where_covers_leave_no_way_in(problem, parts, cleared):
    changed = SimpleNamespace(**{**vars(parts), "collision": Squeamish(parts)})
    straight_ahead = replace(problem, grasps=problem.grasps[:1])
    retrieval = retrieval_of(straight_ahead, changed)
    assert retrieval._grasps.found
    for candidate in retrieval._grasps.found:
        assert changed.collision.in_band(candidate.reach).any()
        ends = np.array([candidate.reach[0], candidate.reach[-1], candidate.lift[-1]])
        assert not changed.collision.in_band(ends).any()
    assert retrieval._unblocked(cleared, retrieval._grasps.found)
    assert not retrieval._unblocked(problem.initial, retrieval._grasps.found)


def test_a_thorough_planner_looks_at_all_grasps(problem, parts, retrieval):
    few = retrieval_of(problem, parts, grasps=2)
    thorough = few.thorough()
    assert {c.number for c in few._grasps.found} < {c.number for c in thorough._grasps.found}
    assert len({c.number for c in thorough._grasps.found}) > RetrievalOptions().grasps
    assert thorough.thorough() is thorough


def test_the_hand_is_slow_where_the_target_nearly_fills_it(shelf_with, parts_of):
    def reach(radius):
        target = (Cylinder(radius, 0.16), Mobility.TARGET, (0.7, -0.5))
        blocker = (Cylinder(0.03, 0.2), Mobility.MOVABLE, (0.9, -0.5))
        problem = shelf_with({"target": target, "blocker": blocker})
        found = retrieval_of(problem, parts_of(problem)).plan(
            problem.initial, np.random.default_rng(0)
        )
        trajectory = found.motion.segments[2].trajectory
        tools = tool_places(parts_of(problem), trajectory.positions, np.eye(4))
        return np.linalg.norm(np.diff(tools, axis=0), axis=1) / np.diff(trajectory.times)

    assert reach(0.03).max() == pytest.approx(0.25, rel=0.05)
    assert reach(0.0445).max() < 0.1


def test_the_target_is_carried_no_faster_than_allowed(problem, parts, found):
    carry = found.motion.segments[4].trajectory
    T = in_the_hand(problem, parts, found.motion)
    places = tool_places(parts, carry.positions, T)
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=1) / np.diff(carry.times)
    assert speeds.max() <= 0.6 * 1.03


def tool_places(parts, rows, T_tool_point):
    return np.array([(parts.kinematics.forward(q) @ T_tool_point)[:3, 3] for q in rows])
