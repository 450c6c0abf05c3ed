"""Pictures of searches that were written down by hand, read as XML."""

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from mamo_core.testing.scenes import two_blockers
from mamo_core.types.region import SweptRegion
from mamo_core.types.search_graph import GraphEdge, GraphVertex, SearchGraph
from mamo_core.view.graph import MOST, chosen, draw_graph, shown
from mamo_core.view.topdown import ARROW, COLORS, REGION

PROBLEM = two_blockers().problem
START = PROBLEM.initial.object_poses
SVG = "{http://www.w3.org/2000/svg}"


def pushed(dy):
    poses = START.copy()
    poses[0, 1] += dy
    return poses


GRAPH = SearchGraph(
    SweptRegion(np.array([0.0, -0.1]), 0.02, np.full((10, 10), 0.0), 0.0),
    (GraphVertex(START), GraphVertex(pushed(0.1)), GraphVertex(pushed(-0.1), predicted=True)),
    (
        GraphEdge(0, 1, "push", "a"),
        GraphEdge(0, None, "push", "b", ("no_ik", "no_room")),
        GraphEdge(0, None, "push", "b", ("no_ik",)),
        GraphEdge(0, 2, "push", "b"),
        GraphEdge(2, 1, "pick_place", "a"),
    ),
    (0, 1),
)


def chain(count):
    """One action after the other; nothing is solved."""
    vertices = tuple(GraphVertex(pushed(0.001 * i)) for i in range(count))
    edges = tuple(GraphEdge(i, i + 1, "push", "a") for i in range(count - 1))
    return SearchGraph(None, vertices, edges)


@pytest.fixture
def drawn(tmp_path):
    def draw(*graphs, problem=PROBLEM):
        draw_graph(problem, graphs, lambda cause: f"<{cause} & so on>", tmp_path / "a.svg")
        return ElementTree.parse(tmp_path / "a.svg").getroot()

    return draw


def texts(root):
    return [element.text for element in root.iter(f"{SVG}text")]


def with_attribute(root, **wanted):
    return [e for e in root.iter() if all(e.get(k) == v for k, v in wanted.items())]


def test_every_rearrangement_is_seen_from_above(drawn):
    root = drawn(GRAPH)
    assert len(list(root.iter(f"{SVG}use"))) == 3
    objects = [e for e in root.iter() if e.find(f"{SVG}title") is not None]
    assert len(objects) == 3 * len(PROBLEM.scene.objects)
    colors = [COLORS[item.mobility] for item in PROBLEM.scene.objects]
    assert [e.get("fill") for e in objects] == 3 * colors
    assert len(with_attribute(root, fill=REGION)) == 1


def test_words_say_what_led_on_and_what_failed_and_why(drawn):
    found = texts(drawn(GRAPH))
    for words in ("#0 start", "#1: the target is taken out", "#2 believed, not executed"):
        assert words in found
    assert "push b x2: <no_ik & so on>" in found
    assert "pick_place a: leads to #1" in found
    assert "two_blockers: 3 rearrangements" in found


def test_the_way_to_the_plan_is_marked(drawn):
    """Two frames and the edge between them, beside the line of the legend."""
    marked = with_attribute(drawn(GRAPH), stroke=ARROW)
    frames = [e for e in marked if e.tag == f"{SVG}rect"]
    edges = [e for e in marked if e.get("stroke-width") == "3"]
    assert (len(frames), len(edges)) == (2, 2)


def test_names_are_escaped(drawn):
    first, *others = PROBLEM.scene.objects
    scene = replace(PROBLEM.scene, objects=(replace(first, name='<a> & "b"'), *others))
    graph = replace(GRAPH, edges=(replace(GRAPH.edges[0], object_name='<a> & "b"'),))
    graph = replace(graph, vertices=GRAPH.vertices[:2])
    assert '<a> & "b"' in texts(drawn(graph, problem=replace(PROBLEM, scene=scene)))


def test_large_graphs_are_cut_and_say_so(drawn):
    root = drawn(chain(MOST + 5))
    assert len(list(root.iter(f"{SVG}use"))) == MOST
    (title,) = (words for words in texts(root) if "rearrangements" in words)
    assert title.endswith("5 of them, the farthest from the solution, are left out")


def test_what_is_near_the_solution_is_kept():
    solved = replace(chain(6), solution=(0, 1, 2, 3, 4))
    assert shown(solved, most=5) == {0, 1, 2, 3, 4}
    assert shown(GRAPH, most=2) == {0, 1}


def test_of_several_graphs_the_one_that_gave_the_plan_is_drawn(drawn):
    assert chosen([chain(3), chain(5), chain(4)]).vertices[4] is not None
    assert chosen([GRAPH, chain(5)]) is GRAPH
    assert "two_blockers: 3 rearrangements under swept region 2 of 3" in texts(
        drawn(chain(9), GRAPH, chain(9))
    )
