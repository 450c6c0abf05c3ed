"""What searches over rearrangements say that they have looked at, on tiny scenes."""

import numpy as np
import pytest

from mamo_core.testing.fakes import StraightPush
from mamo_core.testing.scenes import clear_scene, one_blocker, two_blockers
from mamo_core.types.search_graph import GRAPHS
from mamo_core.verify import VerifyReport

KINDS = [("depth_first", False), ("depth_first", True), ("best_first", False)]


class NoPush(StraightPush):
    def propose(self, state, request, rng, statistics):
        statistics.failed(request.object_name, "push", "no_ik", 2)
        statistics.failed(request.object_name, "push", "no_room", 3)
        return iter(())


@pytest.mark.parametrize(("kind", "lazy"), KINDS)
def test_the_way_to_the_plan_are_its_actions(search_of, kind, lazy):
    problem = two_blockers().problem
    solution = search_of(problem, kind=kind, lazy=lazy).solve()
    (graph,) = solution.info[GRAPHS]
    assert graph.region is not None
    poses = graph.vertices[0].poses
    assert (poses == problem.initial.object_poses).all()
    way = list(zip(graph.solution, graph.solution[1:], strict=False))
    taken = [next(e for e in graph.edges if (e.start, e.end) == step) for step in way]
    assert graph.solution[0] == 0
    assert [(e.kind, e.object_name) for e in taken] == [
        (action.kind, action.object_name) for action in solution.plan.actions
    ]
    for edge in taken:
        moved = graph.vertices[edge.end].poses - graph.vertices[edge.start].poses
        places = np.flatnonzero(np.abs(moved).max(axis=1) > 0.01)
        assert [problem.scene.objects[place].name for place in places] == [edge.object_name]


@pytest.mark.parametrize("kind", ["depth_first", "best_first"])
def test_nothing_is_searched_where_nothing_is_in_the_way(search_of, kind):
    (graph,) = search_of(clear_scene().problem, kind=kind).solve().info[GRAPHS]
    assert (len(graph.vertices), graph.edges, graph.solution) == (1, (), (0,))


def test_failures_keep_their_causes_the_most_frequent_first(search_of):
    problem = one_blocker().problem
    options = {"kind": "depth_first", "regions": 2, "expansions": 1, "agnostic": 1}
    search = search_of(problem, actions=[NoPush(problem)], **options)
    graphs = search.solve().info[GRAPHS]
    assert len(graphs) == 2
    for graph in graphs:
        assert (len(graph.vertices), graph.solution) == (1, ())
        assert {(e.start, e.end, e.kind, e.object_name) for e in graph.edges} == {
            (0, None, "push", "a")
        }
        assert {edge.causes for edge in graph.edges} == {("no_room", "no_ik")}


def test_orders_that_lead_to_the_same_rearrangement_meet(search_of):
    """a then b, b then a: four rearrangements, and four edges between them."""
    options = {"regions": 1, "agnostic": 0, "expansions": 1}
    search = search_of(
        two_blockers().problem,
        verifier=lambda plan: VerifyReport(("no",), None),
        kind="depth_first",
        **options,
    )
    (graph,) = search.solve().info[GRAPHS]
    assert len(graph.vertices) == 4
    assert sorted((e.start, e.end) for e in graph.edges)[:2] == [(0, 1), (0, 2)]
    assert sorted(e.end for e in graph.edges if e.start) == [3, 3]
