"""What is in the scene for a browser, row by row; that a browser shows it: ``tests/browser``."""

import socket
import sys
from dataclasses import replace

import numpy as np
import pytest

from mamo_core.errors import InputError, PluginError
from mamo_core.robots.kinematics import link_transforms
from mamo_core.testing.gantry_arm import gantry_arm
from mamo_core.types.geometry import Box, make_pose, matrix_from_pose
from mamo_core.types.rollout import Violation
from mamo_core.types.scene import Fixture
from mamo_core.view.browser.page import write_html
from mamo_core.view.browser.panel import panel_html
from mamo_core.view.browser.serving import local_server
from mamo_core.view.browser.stage import set_stage
from mamo_core.view.browser.still import rgb
from mamo_core.view.engines import ENGINE_COLORS
from mamo_core.view.topdown import COLORS

ROBOT = gantry_arm()
TIPPED = Violation("tilt", "can", None, 0.52, 0.6, 0.4)
GRAZED = Violation("contact", "robot", "post", 1.0, 1.0, 0.0)
HIT = Violation("contact", "robot", "base", 1.2, 1.0, 0.0)


@pytest.fixture(scope="module")
def server():
    with local_server() as server:
        yield server


@pytest.fixture
def staged(server):
    """``nodes, show = staged(recording)``: all nodes by name, and what shows a row."""

    def staged(recording):
        server.scene.reset()
        show = set_stage(server, recording, ROBOT)
        return server.scene._handle_from_node_name, show

    return staged


def test_objects_have_the_colours_of_their_roles_and_move(staged, recording):
    shown = recording()
    nodes, show = staged(shown)
    for item in shown.problem.scene.objects:
        assert tuple(nodes[f"/objects/{item.name}"].color) == rgb(COLORS[item.mobility])
        assert nodes[f"/objects/{item.name}/name"].text == item.name
    for row in (0, 7, 19):
        show(row)
        assert nodes["/objects/can"].position == pytest.approx(
            shown.executions[0].poses[row, 0, :3]
        )


def test_links_stand_where_kinematics_puts_them(staged, recording):
    shown = recording()
    nodes, show = staged(shown)
    show(13)
    joints = shown.executions[0].joints[13]
    expected = link_transforms(ROBOT, joints, 0.0)
    T, name = np.eye(4), "/robot"
    for link, T_base_link in zip(ROBOT.links, expected, strict=True):
        name = f"{name}/{link.name}"
        node = nodes[name]
        T = T @ matrix_from_pose([*node.position, *node.wxyz])
        assert pytest.approx(T_base_link) == T
    assert T[:3, 3] == pytest.approx(joints[:3])


def test_ghosts_stand_where_another_engine_differs_while_it_does(staged, recording, execution):
    both = recording(execution("a"), execution("b", sideways=0.018))
    nodes, show = staged(both)
    ghosts = [name for name in nodes if name.startswith("/ghosts/b/")]
    assert ghosts == ["/ghosts/b/can"]
    ghost = nodes["/ghosts/b/can"]
    assert tuple(ghost.color) == rgb(ENGINE_COLORS[1])
    assert ghost.opacity < 1.0
    assert not ghost.visible
    show(1)
    assert not ghost.visible, "a millimetre"
    show(10)
    assert ghost.visible
    assert ghost.position == pytest.approx(both.executions[1].poses[10, 0, :3])
    show(0)
    assert not ghost.visible


def test_violations_appear_when_and_where_they_happen(staged, recording, execution):
    nodes, show = staged(recording(execution("a", violations=(TIPPED, GRAZED, HIT))))
    tipped, grazed = nodes["/violations/a 0"], nodes["/violations/a 1"]
    shown = {}
    for row in range(20):
        show(row)
        shown[row] = (tipped.visible, grazed.visible)
    assert [row for row, (tilt, _) in shown.items() if tilt] == list(range(5, 20))
    assert [row for row, (_, contact) in shown.items() if contact] == list(range(10, 20))
    poses = recording().executions[0].poses
    assert tipped.position[:2] == pytest.approx(poses[5, 0, :2])
    assert grazed.position[:2] == pytest.approx(poses[10, 1, :2])
    joints = recording().executions[0].joints
    assert nodes["/violations/a 2"].position == pytest.approx(joints[12, :3]), "at the hand"
    assert nodes["/violations/a 0/text"].text == str(TIPPED)


def test_of_several_engines_a_violation_names_its_own(staged, recording, execution):
    nodes, _ = staged(recording(execution("a"), execution("b", violations=(TIPPED,))))
    assert nodes["/violations/b 0/text"].text == f"b: {TIPPED}"


def test_the_caption_says_what_is_done(staged, recording):
    nodes, show = staged(recording())
    texts = []
    for row in range(0, 20, 5):
        show(row)
        texts.append(nodes["/caption"].text)
    assert texts == ["push can: sweep", "push can: retract", "retrieve: sweep", "retrieve: retract"]


def test_fixtures_that_carry_are_opaque_and_others_let_the_view_through(staged, recording):
    shown = recording()
    top = Fixture("top", Box(np.array([0.6, 0.8, 0.04])), make_pose([0.78, -0.5, 1.1]))
    scene = replace(shown.problem.scene, fixtures=(*shown.problem.scene.fixtures, top))
    nodes, _ = staged(replace(shown, problem=replace(shown.problem, scene=scene)))
    assert nodes["/fixtures/base"].opacity is None
    assert nodes["/fixtures/top"].opacity < 0.5


def test_region_and_paths_of_the_plan(staged, recording):
    shown = recording()
    nodes, _ = staged(shown)
    assert nodes["/swept"].opacity < 1.0
    path = nodes["/paths/1 can"]
    assert path.points[0, :, :2] == pytest.approx(shown.plan.actions[0].path)
    alone = replace(shown.plan, region=None, actions=())
    nodes, _ = staged(replace(shown, plan=alone, segments=shown.segments // 2))
    assert not [name for name in nodes if name.startswith(("/swept", "/paths"))]


def test_the_panel_tells_colours_failures_and_differences(recording, execution):
    failed = execution("b", sideways=0.02, violations=(TIPPED,), failures=(f"{TIPPED}",))
    text = panel_html(recording(execution("a"), failed))
    assert "holds in a" in text
    assert "fails in b" in text
    assert "tilt: can at 0.520 s (0.6 &gt; 0.4)" in text
    for role in ("movable", "immovable", "target"):
        assert f"</span>{role}</div>" in text
    assert ENGINE_COLORS[1] in text
    assert "data:image/png;base64," in text
    assert "data:image" not in panel_html(recording())


def test_a_page_is_one_small_file_and_the_same_again(recording, tmp_path, capsys):
    for name in ("one.html", "two.html"):
        write_html(recording(), ROBOT, tmp_path / name)
    text = (tmp_path / "one.html").read_text(encoding="utf-8")
    assert "<title>transition_cases</title>" in text
    assert "<link" not in text.replace('<link\n      rel="icon"\n      href="data:', "")
    assert "<script src" not in text
    assert len(text) < 2e6
    assert text == (tmp_path / "two.html").read_text(encoding="utf-8")
    assert capsys.readouterr().out == "", "stdout is for results"


def test_a_server_listens_to_this_machine_alone(server):
    port = server.get_port()
    socket.create_connection(("127.0.0.1", port), timeout=10).close()
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.2", port), timeout=10)


def test_a_port_in_use_is_refused(server):
    port = server.get_port()
    with pytest.raises(InputError, match=f"--port {port}: in use"), local_server(port):
        pass


def test_without_viser_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    with (
        pytest.raises(PluginError, match=r"needs viser: pip install 'mamo\[view\]'"),
        local_server(),
    ):
        pass
