"""Whatever happens to an engine's process, one rollout is lost and the next one is not."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import signal
import time
from functools import partial
from pathlib import Path

import pytest

from mamo_core.compose import compose
from mamo_core.errors import WorkerCrashedError
from mamo_core.plugins import Registry, discover, make_registry
from mamo_core.problems import load_problem
from mamo_core.recipe_sets import apply_sets
from mamo_core.recipes import find_recipe, load_recipe
from mamo_core.simulation.isolated import IsolatedModel, isolated
from mamo_core.testing.conformance.repeatability import require_same
from mamo_core.testing.transition_cases import gantry_cases

CASES = gantry_cases()
START = CASES.problem.initial
PROBLEM = Path(__file__).parents[3] / "problems" / "shelf_10_medium_seed1.yaml"


@pytest.fixture
def mortal(monkeypatch):
    """The module, importable here and in new processes."""
    monkeypatch.syspath_prepend(Path(__file__).parent)
    return importlib.import_module("mortal_models")


@pytest.fixture
def one_worker(mortal):
    made = []

    def make(end, patience=60.0):
        made.append(IsolatedModel(partial(mortal.DiesOfCrashes, end), 1, patience))
        return made[-1]

    yield make
    for model in made:
        model.close()


@pytest.mark.parametrize(
    ("end", "why"),
    [("abort", "exit code -6"), ("kill", "exit code -9"), ("exit", "exit code 3")],
)
def test_a_process_that_ends_loses_one_rollout(one_worker, mortal, end, why):
    model = one_worker(end)
    lost = model.rollout(START, CASES.crash)
    assert lost.lost is not None
    assert why in lost.lost
    assert not lost.valid
    require_same(mortal.fake().rollout(START, CASES.push), model.rollout(START, CASES.push))


def test_only_the_rollout_of_a_batch_that_ended_the_process_is_lost(one_worker, mortal):
    model = one_worker("abort")
    motions = [CASES.push, CASES.still, CASES.crash, CASES.still, CASES.push]
    results = model.rollout_batch([START] * 5, motions)
    assert [result.lost is None for result in results] == [True, True, False, True, True]
    require_same(mortal.fake().rollout(START, CASES.push), results[-1])


def test_a_process_that_is_killed_while_it_waits_costs_nothing(one_worker, mortal):
    model = one_worker("abort")
    model.rollout(START, CASES.still)
    for worker in multiprocessing.active_children():
        os.kill(worker.pid, signal.SIGKILL)
        worker.join()
    require_same(mortal.fake().rollout(START, CASES.push), model.rollout(START, CASES.push))


def test_several_workers_give_what_one_gives(mortal):
    model = IsolatedModel(partial(mortal.DiesOfCrashes, "kill"), 2, 60.0)
    motions = [CASES.push, CASES.crash, CASES.still, CASES.push, CASES.crash]
    results = model.rollout_batch([START] * 5, motions)
    model.close()
    assert [result.lost is None for result in results] == [True, False, True, True, False]
    require_same(results[0], results[3])


def test_a_hang_ends_with_patience(one_worker):
    model = one_worker("hang", patience=5.0)
    model.rollout(START, CASES.still)  # so that the worker is there
    started = time.monotonic()
    lost = model.rollout(START, CASES.crash)
    assert lost.lost == "the engine gave no answer for 5 s"
    assert time.monotonic() - started < 60.0
    assert model.rollout(START, CASES.push).lost is None


def test_time_in_the_worker_is_told(one_worker):
    assert one_worker("abort").rollout(START, CASES.push).outside_cpu > 0.0


def test_errors_of_the_model_come_through(one_worker):
    with pytest.raises(ValueError, match="continue_from"):
        one_worker("abort").rollout(START, CASES.push, continue_from=object())


def test_an_engine_that_cannot_be_built_says_why(mortal):
    model = IsolatedModel(mortal.refuses, 1, 60.0)
    with pytest.raises(ValueError, match="cannot build this scene"):
        model.rollout(START, CASES.push)
    model.close()


def test_a_process_that_ends_while_it_is_asked_for_the_tool(one_worker):
    with pytest.raises(WorkerCrashedError, match="exit code -6"):
        one_worker("abort").tool_pose(START)


def test_without_workers_it_is_the_model_itself(mortal):
    assert type(isolated(mortal.fake, 0, 60.0)) is type(mortal.fake())


@pytest.mark.parametrize("end", ["abort", "kill"])
def test_planning_goes_on_when_the_engine_ends(mortal, tmp_path, end):
    part = f"backend={{name: mortal, end: {end}, dead: {tmp_path / 'dead'}}}"
    loaded = load_recipe(apply_sets(find_recipe("m4m"), [part]))
    problem = load_problem(PROBLEM)
    mortals = make_registry([("mortal", lambda: mortal)])
    registry = Registry((*discover().registered, *mortals.registered))
    planner = compose(loaded, problem, registry)
    solution = planner.solve(seed=0)
    assert (tmp_path / "dead").exists()
    assert solution.plan is not None
    assert planner.verify(solution.plan).ok
    (lost,) = [key for key in solution.statistics.causes if "process died" in key]
    assert solution.statistics.causes[lost] == 1
    planner.context.backend.close()
