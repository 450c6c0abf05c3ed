"""Samples of masses and frictions: whom a robust search asks, and about what."""

from dataclasses import replace

import numpy as np
import pytest
from mamo_planners.search.options import Uncertainty

from mamo_core.testing.gantry import GantryKinematics
from mamo_core.testing.quasi_static import QuasiStaticModel
from mamo_core.testing.scenes import one_blocker
from mamo_core.testing.transition_cases import standard_constraints
from mamo_core.types.motion import SegmentKind
from mamo_core.types.rollout import ParameterOverrides
from mamo_core.types.solution import SolutionStatus

HEAVY = 50.0


def robust(search_of, threshold=1.0, **options):
    """A search of four samples that know masses and frictions exactly."""
    uncertainty = Uncertainty(
        simulators=4,
        copies=1,
        threshold=threshold,
        mass_spread=0.0,
        friction_spread=0.0,
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
        number = [engine.parameters is parameters for engine in search.engines].index(True)
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
        monkeypatch.setattr(made._samples, "_transit_free", lambda *_: True)
        made._samples._collision = FreeOnlyInTheFirstEngine()
        return made

    search.search._parts = replace(search.search._parts, execution=execution)
    assert search.solve().status is SolutionStatus.SOLVED
    pushes = [n for n, motion in asked if motion.segments[-1].kind is SegmentKind.RETRACT]
    assert pushes == [0, 1, 1, 2, 2, 3, 3, 0]


@pytest.mark.parametrize(("near", "solved"), [(0, True), (1, False)])
def test_a_retrieval_is_clear_in_all_samples_and_executed_in_none(
    search_of, monkeypatch, near, solved
):
    answers = [False] * near + [True] * (3 - near)
    search = robust(
        search_of, threshold=0.75, expansions=1, regions=1, clear=lambda *_: answers.pop()
    )
    asked = watched(search, monkeypatch)
    assert (search.solve().status is SolutionStatus.SOLVED) == solved
    retrievals = [n for n, m in asked if m.segments[-1].kind is SegmentKind.CARRY]
    assert set(retrievals) == ({0} if solved else set())


class Seen(QuasiStaticModel):
    """Counts its rollouts; where things are ``heavy``, nothing can be pushed."""

    def __init__(self, problem, heavy=False):
        super().__init__(problem, GantryKinematics().forward, standard_constraints(problem))
        self.rollouts = 0
        self.heavy = ParameterOverrides(dict.fromkeys(["a"], HEAVY)) if heavy else None

    def rollout(self, state, motion, *, parameters=None, **more):
        self.rollouts += 1
        return super().rollout(state, motion, parameters=self.heavy or parameters, **more)


@pytest.mark.parametrize("heavy", [False, True])
def test_actions_are_tried_in_an_engine_of_their_own(search_of, heavy):
    problem = one_blocker().problem
    trial, leading = Seen(problem, heavy), Seen(problem)
    search = search_of(
        problem, kind="depth_first", model=leading, trial=trial, regions=1, expansions=1, agnostic=0
    )
    solution = search.solve()
    assert (solution.status is SolutionStatus.SOLVED) != heavy
    assert trial.rollouts == 1
    # The push, the retrieval, and the verifier's replay.
    assert leading.rollouts == (0 if heavy else 3)


class NothingIsFree(FreeOnlyInTheFirstEngine):
    def free(self, configurations):
        return np.zeros(len(configurations), dtype=bool)


def test_transits_keep_the_planners_distance_in_samples(search_of, monkeypatch):
    search = robust(search_of, expansions=1, regions=1)
    make = search.search._parts.execution

    def execution(*arguments):
        made = make(*arguments)
        monkeypatch.setattr(made._samples, "_free_after", lambda *_: True)
        made._samples._collision = NothingIsFree()
        return made

    search.search._parts = replace(search.search._parts, execution=execution)
    solution = search.solve()
    assert solution.status is not SolutionStatus.SOLVED
    assert solution.statistics.causes["a/push/not_valid_in_samples"] >= 1
