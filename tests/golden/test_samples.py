"""Samples of masses and frictions: whom a robust search asks, and about what."""

from dataclasses import replace

import numpy as np
import pytest
from mamo_planners.search.options import Uncertainty

from mamo_core.testing.scenes import one_blocker
from mamo_core.types.motion import SegmentKind
from mamo_core.types.solution import SolutionStatus

HEAVY = 50.0


def robust(search_of, threshold=1.0, fresh=0, fresh_threshold=0.84, **options):
    """A search of four samples that know masses and frictions exactly."""
    uncertainty = Uncertainty(
        simulators=4,
        copies=1,
        threshold=threshold,
        mass_spread=0.0,
        friction_spread=0.0,
        fresh=fresh,
        fresh_threshold=fresh_threshold,
    )
    settings = {"kind": "depth_first", "uncertainty": uncertainty, "agnostic": 0, **options}
    return search_of(one_blocker().problem, **settings)


def watched(search, monkeypatch, heavy=()):
    """Numbers of the samples that are asked, with their motions; ``heavy`` ones cannot push."""
    asked = []
    rollout = search.model.rollout

    def seen(state, motion, *, parameters=None, **more):
        if parameters is None:  # the verifier's
            return rollout(state, motion, **more)
        own = [engine.parameters is parameters for engine in search.engines]
        if True not in own:  # a fresh sample's
            return rollout(state, motion, parameters=parameters, **more)
        number = own.index(True)
        asked.append((number, motion))
        if number in heavy:
            parameters = replace(parameters, masses=dict.fromkeys(parameters.masses, HEAVY))
        return rollout(state, motion, parameters=parameters, **more)

    monkeypatch.setattr(search.model, "rollout", seen)
    return asked


def test_who_refused_is_asked_first_next_time(search_of, monkeypatch):
    search = robust(search_of, expansions=3, forbidden_radius=0.03)
    asked = watched(search, monkeypatch, heavy=(3,))
    assert search.solve().status is not SolutionStatus.SOLVED
    followers = [number for number, _ in asked if number != 0]
    assert followers[:3] == [1, 2, 3]
    assert len(followers) > 3
    assert set(followers[3:]) == {3}


def test_no_more_are_asked_than_it_takes_to_refuse(search_of, monkeypatch):
    search = robust(search_of, threshold=0.75, expansions=1)
    asked = watched(search, monkeypatch, heavy=(1, 2))
    assert search.solve().status is not SolutionStatus.SOLVED
    assert {number for number, _ in asked} == {0, 1, 2}


def test_samples_are_not_asked_about_the_way_back_where_nothing_is(search_of, monkeypatch):
    search = robust(search_of)
    asked = watched(search, monkeypatch)
    assert search.solve().status is SolutionStatus.SOLVED
    back = {0: [], 1: []}
    for number, motion in asked:
        last = motion.segments[-1]
        if last.kind is SegmentKind.RETRACT:
            back[min(number, 1)].append(last.trajectory.duration)
    assert max(back[1]) < min(back[0])


class FreeOnlyInTheFirstEngine:
    """The first answer is about where the first engine ends, all others about samples."""

    def __init__(self):
        self._answers = iter([True])

    def world(self, object_poses, **options):
        return self

    def free(self, configurations):
        return np.full(len(configurations), next(self._answers, False))


def test_a_way_back_that_is_not_free_is_simulated_to_its_end(search_of, monkeypatch):
    search = robust(search_of)
    asked = watched(search, monkeypatch)
    make = search.search._parts.execution

    def execution(*arguments):
        made = make(*arguments)
        made._samples._collision = FreeOnlyInTheFirstEngine()
        return made

    search.search._parts = replace(search.search._parts, execution=execution)
    assert search.solve().status is SolutionStatus.SOLVED
    pushes = [n for n, motion in asked if motion.segments[-1].kind is SegmentKind.RETRACT]
    assert pushes == [0, 1, 1, 2, 2, 3, 3, 0]


def with_fresh(search, monkeypatch, heavy=()):
    """What fresh samples are asked about, by who was drawn; the ``heavy`` ones cannot push."""
    asked = []
    rollout = search.model.rollout

    def seen(state, motion, *, parameters=None, **more):
        own = any(engine.parameters is parameters for engine in search.engines)
        if parameters is None or own:
            return rollout(state, motion, parameters=parameters, **more)
        if not any(parameters is other for other in asked):
            asked.append(parameters)
        number = [parameters is other for other in asked].index(True)
        if number in heavy:
            parameters = replace(parameters, masses=dict.fromkeys(parameters.masses, HEAVY))
        return rollout(state, motion, parameters=parameters, **more)

    monkeypatch.setattr(search.model, "rollout", seen)
    return asked


def test_a_plan_that_fresh_samples_execute_is_returned_as_it_was_found(search_of, monkeypatch):
    alone, search = robust(search_of), robust(search_of, fresh=3)
    asked = with_fresh(search, monkeypatch)
    without, found = alone.solve().plan, search.solve().plan
    assert len(asked) == 3
    assert [a.path.tolist() for a in found.actions] == [a.path.tolist() for a in without.actions]


@pytest.mark.parametrize("heavy", [(0,), (2,)])
def test_after_one_that_fails_as_many_others_must_hold(search_of, monkeypatch, heavy):
    search = robust(search_of, fresh=3, expansions=1, regions=1)
    asked = with_fresh(search, monkeypatch, heavy)
    assert search.solve().status is SolutionStatus.SOLVED
    assert len(asked) == 6


def test_a_larger_share_of_them_may_fail(search_of, monkeypatch):
    search = robust(search_of, fresh=3, fresh_threshold=0.5, expansions=1, regions=1)
    asked = with_fresh(search, monkeypatch, heavy=(0, 2, 5))
    assert search.solve().status is SolutionStatus.SOLVED
    assert len(asked) == 6


@pytest.mark.parametrize("heavy", [(0, 1), (0, 3), (2, 5)])
def test_two_that_fail_refuse_the_plan(search_of, monkeypatch, heavy):
    search = robust(search_of, fresh=3, expansions=1, regions=1)
    with_fresh(search, monkeypatch, heavy)
    solution = search.solve()
    assert solution.status is not SolutionStatus.SOLVED
    assert any("not_valid_in_fresh_samples" in cause for cause in solution.statistics.causes)


def test_every_plan_meets_samples_of_its_own(search_of, monkeypatch):
    search = robust(search_of, fresh=3, expansions=3, forbidden_radius=0.03)
    asked = with_fresh(search, monkeypatch, heavy=(0, 1))
    assert search.solve().status is SolutionStatus.SOLVED
    assert len(asked) > 3
