"""What planners that reach do on tiny scenes, step by step."""

import numpy as np
import pytest

from mamo_core.testing.scenes import (
    one_blocker,
    reach_between_corners,
    reach_by_pushing,
    reach_past,
    reach_past_a_corner,
    reach_without_room,
)
from mamo_core.types.scene import Mobility

NAIVE_DD = {"subgoals": 0, "snap": False, "rounds": 1}


NEAR = 0.12
"""A hand farther from the centre of a box (6 cm wide, pushed by a few cm) cannot touch it, m."""


def starts(engine):
    """Where the tool was when motions began, cm."""
    return [tuple(np.rint(100 * m.start[:3]).astype(int).tolist()) for m in engine.motions]


def drawn(*counts):
    names = ("expansions", "drawn_primitives", "simulated_primitives", "soft_duplicates")
    return dict(zip(names, counts, strict=True))


FIRST = [(38, -2, 15), (31, -2, 8), (29, 7, 12), (37, -2, 15)]
SECOND = [(40, -2, 14), (33, 2, 14), (43, 10, 5), (34, -3, 7)]


@pytest.mark.parametrize(
    ("scene", "options", "counts", "simulated"),
    [
        (reach_by_pushing(), {}, drawn(1, 8, 8, 0), FIRST + SECOND),
        (reach_past(one_blocker()), {}, drawn(1, 8, 2, 0), [(24, -6, 14), (25, 10, 15)]),
        (reach_by_pushing(), NAIVE_DD, drawn(11, 0, 1, 0), [(31, 0, 5)]),
        (
            reach_without_room(),
            {**NAIVE_DD, "expansions": 200},
            drawn(200, 0, 2, 78),
            [(36, -2, 5), (36, -3, 5)],
        ),
    ],
    ids=["spamp", "spamp_past_a_box", "naive_dd", "naive_dd_without_room"],
)
def test_spamp_simulates(reaching, scene, options, counts, simulated):
    world = reaching(scene.problem)
    solution = world.solve(world.spamp(**options))
    assert {name: solution.statistics.counts[name] for name in counts} == counts
    assert starts(world.engines[0]) == simulated
    assert (solution.plan is not None) is scene.solvable


def test_spamp_in_rounds(reaching):
    world = reaching(reach_without_room().problem)
    solution = world.solve(world.spamp(rounds=3, expansions=20))
    counts = dict(solution.statistics.counts)
    assert counts.pop("steps") >= counts["rollouts"]
    assert counts == {
        "rounds": 3,
        "drawn_primitives": 24,
        "simulated_primitives": 24,
        "rollouts": 24,
        "expansions": 80,
        "soft_duplicates": 46,
    }
    assert solution.statistics.causes == {
        "a/reach/contact": 22,
        "a/reach/speed": 4,
        "e/reach/speed": 1,
    }


@pytest.mark.parametrize(
    ("scene", "step", "relevant"),
    [
        (reach_past_a_corner(), 4.0, ["", "a"]),
        (reach_between_corners(), 3.0, ["", "a", "ab"]),
    ],
    ids=["corner", "corners"],
)
def test_selective_simulation_in_phases(reaching, scene, step, relevant):
    """How much is simulated hangs on near ties between queues: only for what it is, is pinned."""
    world = reaching(scene.problem)
    solution = world.solve(world.selective(large_step_deg=step))
    tracking, *planning = world.engines
    assert ["".join(movables(engine)) for engine in planning] == relevant
    assert solution.statistics.counts["planning_phases"] == len(relevant)
    # Nothing is simulated as long as nothing is relevant, and then only what the hand may touch.
    counts = [len(engine.motions) for engine in planning]
    assert counts[0] == 0
    assert all(counts[1:])
    for engine in planning[1:]:
        assert all(meets(engine.problem, motion) for motion in engine.motions)
    # Each phase is tracked: the hand opens, and the rest.
    assert len(tracking.motions) == 2 * len(relevant)
    assert solution.plan is not None


def meets(problem, motion):
    """Whether a motion begins or ends so near a relevant movable that they may touch."""
    places = [problem.scene.index(name) for name in movables_of(problem)]
    ends = np.stack([motion.start, motion.end])[:, None, :2]
    return np.linalg.norm(ends - problem.initial.object_poses[places, :2], axis=2).min() < NEAR


def movables(engine):
    return movables_of(engine.problem)


def movables_of(problem):
    return [o.name for o in problem.scene.objects if o.mobility is Mobility.MOVABLE]
