"""Where two executions part: on recorded motions that are written down by hand."""

from dataclasses import replace

import numpy as np
import pytest

from mamo_core.compare.divergence import APART, compare_actions, separation
from mamo_core.compare.execute import shifted
from mamo_core.recording.tracks import align
from mamo_core.testing.transition_cases import gantry_cases
from mamo_core.types.geometry import make_pose
from mamo_core.types.rollout import RolloutResult, Trace

STEP = 0.1
CASES = gantry_cases()
SCENE = CASES.problem.scene
NAMES = [item.name for item in SCENE.objects]


def recorded(durations, edit=lambda poses, contacts, times: None):
    """A rollout of two segments with these durations (s), in which nothing moves but by edit."""
    starts = np.concatenate([[0.0], np.cumsum(durations)])
    times = STEP * np.arange(round(starts[-1] / STEP) + 1)
    poses = np.repeat(CASES.problem.initial.object_poses[None], len(times), axis=0)
    entities = len(SCENE.entities)
    contacts = np.zeros((len(times), entities, entities), dtype=bool)
    edit(poses, contacts, times)
    trace = Trace(times, np.zeros((len(times), 4)), np.zeros(len(times)), poses, contacts)
    return RolloutResult(
        CASES.problem.initial,
        (),
        (),
        frozenset(),
        False,
        float(starts[-1]),
        0,
        segment_times=tuple(starts[:-1]),
        trace=trace,
    )


def parted(one, other, motions=(CASES.push,)):
    tracks = align({"a": one, "b": other})
    return compare_actions(SCENE, motions, tracks, ("a", "b"))


def test_an_engine_that_settles_sooner_waits():
    tracks = align({"a": recorded([1.0, 0.5]), "b": recorded([0.4, 0.5])})
    assert (tracks.segments == np.repeat([0, 1], [10, 5])).all()
    assert len(tracks.poses["a"]) == len(tracks.poses["b"]) == 15


def test_the_grid_ends_where_the_first_engine_stopped():
    short = recorded([1.0, 0.5])
    short = replace(short, segment_times=short.segment_times[:1], duration=1.0)
    assert set(align({"a": recorded([1.0, 0.5]), "b": short}).segments) == {0}


def test_a_rollout_without_trace_is_refused():
    with pytest.raises(ValueError, match="'b' has recorded no trace"):
        align({"a": recorded([1.0, 0.5]), "b": replace(recorded([1.0, 0.5]), trace=None)})


def test_engines_that_agree():
    (only,) = parted(recorded([1.0, 0.5]), recorded([0.4, 0.5]))
    assert only.first is None
    assert only.apart == only.turned == 0.0


def test_position_names_first_time_and_object():
    can = NAMES.index("can")

    def edit(poses, contacts, times):
        poses[times > 0.45, can, 1] += 1.5 * APART
        poses[times > 0.75, NAMES.index("bystander"), 1] += 5.0 * APART

    (only,) = parted(recorded([1.0, 0.5]), recorded([1.0, 0.5], edit))
    assert (only.first.kind, only.first.subject) == ("position", "can")
    assert only.first.time == pytest.approx(0.5)
    assert only.first.value == pytest.approx(1.5 * APART)
    assert only.apart == pytest.approx(5.0 * APART)


def test_each_action_is_compared_from_its_own_start():
    def edit(poses, contacts, times):
        poses[times > 1.15, 0, 0] += 2.0 * APART

    first, second = CASES.push.segments
    motions = [replace(CASES.push, segments=(segment,)) for segment in (first, second)]
    one, two = parted(recorded([1.0, 0.5]), recorded([1.0, 0.5], edit), motions)
    assert one.first is None
    assert two.action == 1
    assert two.first.time == pytest.approx(0.2)


def test_a_contact_of_one_engine_alone():
    pair = 0, 1 + NAMES.index("can")

    def touch_late(poses, contacts, times):
        contacts[times > 0.75, *pair] = True

    def touch_soon(poses, contacts, times):
        contacts[times > 0.25, *pair] = True

    (both,) = parted(recorded([1.0, 0.5], touch_soon), recorded([1.0, 0.5], touch_late))
    assert both.first is None, "the same contact at another time is no disagreement"
    (alone,) = parted(recorded([1.0, 0.5]), recorded([1.0, 0.5], touch_late))
    assert (alone.first.kind, alone.first.subject) == ("contact", "robot - can")
    assert alone.first.value == 2.0


def test_nobody_sees_a_cylinder_turn_about_its_axis():
    box, can = NAMES.index("bystander"), NAMES.index("can")
    one = CASES.problem.initial.object_poses[None].copy()
    other = one.copy()
    for i in (box, can):
        other[0, i] = make_pose(one[0, i, :3], 0.3)
    distances, angles = separation(SCENE, one, other)
    assert distances.max() == 0.0
    assert angles[0, box] == pytest.approx(0.3)
    assert angles[0, can] == pytest.approx(0.0, abs=1e-6)


def test_shifted_poses_stay_close_and_are_repeatable():
    start = CASES.problem.initial
    one, same = (shifted(start, np.random.default_rng(3)) for _ in range(2))
    change = np.abs(one.object_poses - start.object_poses)
    assert 0.0 < change.max() <= 1e-4
    assert np.array_equal(one.object_poses, same.object_poses)
