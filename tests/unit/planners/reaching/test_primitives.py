"""Adaptive motion primitives: where they begin, what is valid, and which may push."""

from itertools import islice

import numpy as np
import pytest
from mamo_planners.reaching.amp import Mix, Primitives
from mamo_planners.reaching.goals import Goals
from mamo_planners.reaching.options import LatticeOptions
from mamo_planners.reaching.promising import Promising
from mamo_planners.reaching.scenery import look_at

from mamo_core.testing.scenes import (
    HOME,
    clear_scene,
    one_blocker,
    reach_by_pushing,
    reach_past,
    walled_in,
)

GOAL = np.array([0.35, 0.0, 0.05, 0.0])


def rng():
    return np.random.default_rng(0)


@pytest.fixture
def primitives_of(reaching):
    def make(scene, delta=0.2, promising=None):
        parts = reaching(scene.problem).parts
        goals = Goals(parts.problem, parts.arm, parts.kinematics, parts.collision, rng())
        seen = look_at(parts, goals, LatticeOptions())
        worlds = seen.fixed, seen.everything
        varied = promising or Promising()
        return Primitives(parts.arm, parts.kinematics, goals, *worlds, seen.field, varied, delta)

    return make


def away(x=0.0, y=0.0, z=0.0):
    return GOAL + np.array([x, y, z, 0.0])


def test_straight_to_the_goal(primitives_of):
    primitive = primitives_of(reach_past(clear_scene())).to_goal(HOME, rng())
    assert not primitive.interacts
    assert primitive.path == pytest.approx(np.stack([HOME, GOAL]))


def test_what_may_meet_a_movable_interacts(primitives_of):
    primitives = primitives_of(reach_past(one_blocker()))
    assert primitives.to_goal(HOME, rng()).interacts
    assert not primitives.to_goal(away(y=-0.2), rng()).interacts


def test_it_is_parted_where_it_may_first_touch_something(primitives_of):
    primitives = primitives_of(reach_past(one_blocker()))
    parted = primitives.to_goal(HOME, rng())
    assert parted.approach[0] == pytest.approx(HOME)
    assert parted.approach[-1] == pytest.approx(parted.sweep[0])
    assert parted.sweep[-1] == pytest.approx(GOAL)
    # The box is 0.45 m ahead of the gantry's home, hand and box are some centimetres long.
    assert HOME[0] + 0.1 < parted.sweep[0, 0] < 0.25
    free = primitives.to_goal(away(y=-0.2), rng())
    assert len(free.sweep) == 0
    assert free.approach == pytest.approx(free.path)


def test_a_goal_that_a_movable_covers_interacts_from_anywhere(primitives_of):
    primitives = primitives_of(reach_by_pushing())
    assert all(primitives.to_goal(away(y=y), rng()).interacts for y in (-0.2, 0.2))


def test_what_meets_an_immovable_is_none(primitives_of):
    primitives = primitives_of(reach_past(walled_in()))
    assert primitives.to_goal(HOME, rng()) is None
    assert primitives.to_goal(away(y=-0.2), rng()) is not None


@pytest.mark.parametrize(("y", "begins"), [(-0.1, True), (-0.19, True), (-0.24, False)])
def test_they_begin_within_delta(primitives_of, y, begins):
    assert primitives_of(reach_past(clear_scene())).begins_at(away(y=y)) is begins


def test_delta_is_measured_around_immovables(primitives_of):
    beyond = away(x=-0.16, z=0.01)
    assert primitives_of(reach_past(clear_scene())).begins_at(beyond)
    assert primitives_of(reach_past(one_blocker())).begins_at(beyond)
    assert not primitives_of(reach_past(walled_in())).begins_at(beyond)


def test_drawn_ones_begin_free_and_within_delta(primitives_of):
    primitives = primitives_of(reach_by_pushing())
    drawn = list(islice(primitives.drawn(rng(), np.array, Mix()), 12))
    assert len(drawn) == 12
    assert all(primitives.begins_at(p.start) for p in drawn)
    assert all(primitives._everything.free(p.start)[0] for p in drawn)
    spread = np.ptp([p.start for p in drawn], axis=0)
    assert (spread > 0.05).all()


def test_drawn_ones_begin_where_they_are_rounded_to(primitives_of):
    primitives = primitives_of(reach_past(clear_scene()))
    drawn = islice(primitives.drawn(rng(), lambda q: np.round(q, 1), Mix()), 5)
    assert all(np.array_equal(p.start, np.round(p.start, 1)) for p in drawn)


def test_drawing_ends_where_nothing_is_to_be_had(primitives_of):
    nowhere = primitives_of(reach_past(clear_scene()), delta=1e-3)
    # Rounded to where no primitive begins.
    assert list(nowhere.drawn(rng(), lambda q: HOME, Mix())) == []


def test_variations_bend_near_what_held_longest(primitives_of):
    promising = Promising()
    primitives = primitives_of(reach_by_pushing(), promising=promising)
    model = primitives.to_goal(away(x=-0.15), rng())
    promising.failed(model, 0.9)
    varied = list(islice(primitives.drawn(rng(), np.array, Mix(vary=1.0)), 6))
    assert len(varied) == 6
    assert all(len(p.path) == 3 for p in varied)
    assert all(np.abs(p.start - model.start).max() < 0.5 for p in varied)
    assert len({p.start.tobytes() for p in varied}) == 6


def test_nothing_is_varied_before_something_failed(primitives_of):
    primitives = primitives_of(reach_by_pushing())
    drawn = islice(primitives.drawn(rng(), np.array, Mix(vary=1.0)), 3)
    assert all(len(p.path) == 2 for p in drawn)
