"""Every renderer that is installed draws what recordings hold. Needs OpenGL without a screen:
see docs/look_at_plans.md; part of `make test-view`."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from mamo_core.cli.main import main
from mamo_core.plugins import discover
from mamo_core.recording import write_recording
from mamo_core.testing.transition_cases import pr2_cases
from mamo_core.types.recording import RecordedExecution, Recording
from mamo_core.types.region import SweptRegion
from mamo_core.types.rollout import Violation
from mamo_core.types.scene import Mobility
from mamo_core.types.solution import Plan
from mamo_core.view.renderers import ROLE, renderer_for
from mamo_core.view.shots import BROKEN, shot_of

pytestmark = pytest.mark.rendering

CASES = pr2_cases()
PROBLEM = CASES.problem
SHOT = shot_of(PROBLEM, 240, 180)
TIPPED = Violation("tilt", CASES.pushed, None, 0.1, 0.6, 0.4)


@pytest.fixture(params=[c.name for c in discover().components(ROLE)])
def renderer(request):
    return renderer_for(PROBLEM, discover(), request.param)


def execution(name="mujoco", moved=0.2, violations=()):
    """Ten rows in which one object slides to the left by ``moved`` (m) and the arm turns."""
    share = np.linspace(0.0, 1.0, 10)
    poses = np.repeat(PROBLEM.initial.object_poses[None], 10, axis=0)
    poses[:, PROBLEM.scene.index(CASES.pushed), 1] += moved * share
    joints = np.repeat(PROBLEM.initial.joint_positions[None], 10, axis=0)
    joints[:, 0] += 0.5 * share
    contacts = np.zeros((10, *2 * (len(PROBLEM.scene.entities),)), dtype=bool)
    return RecordedExecution(name, joints, np.full(10, 0.05), poses, contacts, violations)


def recording(*executions):
    plan = Plan((), CASES.still, None)
    return Recording(PROBLEM, plan, 0.02 * np.arange(10), np.zeros(10, dtype=int), executions)


def drawn(renderer, recording, *rows):
    return [image.astype(int) for image in renderer.frames(recording, rows, SHOT)]


def area(image, color):
    """How many pixels have that colour, in whatever light."""
    wanted = np.array([int(color[i : i + 2], 16) for i in (1, 3, 5)])
    shade = image / np.maximum(image.max(axis=2, keepdims=True), 1)
    return int((np.abs(shade - wanted / wanted.max()).max(axis=2) < 0.06).sum())


def changed(one, other):
    return int((np.abs(one - other).max(axis=2) > 24).sum())


def test_pictures_have_the_size_that_was_asked_for(renderer):
    images = list(renderer.frames(recording(execution()), range(0, 10, 3), SHOT))
    assert [image.shape for image in images] == 4 * [(180, 240, 3)]
    assert {image.dtype for image in images} == {np.dtype(np.uint8)}


def test_objects_have_the_colours_of_their_roles(renderer):
    (image,) = drawn(renderer, recording(execution()), 0)
    for mobility in Mobility:
        assert area(image, SHOT.colors[mobility]) > 30, mobility


def test_objects_and_the_arm_move(renderer):
    first, last = drawn(renderer, recording(execution()), 0, 9)
    assert changed(first, last) > 200
    still = execution(moved=0.0)
    first, turned = drawn(renderer, recording(still), 0, 9)
    assert changed(first, turned) > 100
    arm = replace(still, joints=np.repeat(still.joints[:1], 10, axis=0))
    first, same = drawn(renderer, recording(arm), 0, 9)
    assert changed(first, same) == 0


def test_the_gripper_opens(renderer):
    whole = execution(moved=0.0)
    joints = np.repeat(whole.joints[:1], 10, axis=0)
    opening = replace(whole, joints=joints, openings=np.linspace(0.0, 0.08, 10))
    closed, opened = drawn(renderer, recording(opening), 0, 9)
    assert 0 < changed(closed, opened) < 2000


def test_what_broke_a_constraint_turns_red_from_then_on(renderer):
    broken = recording(execution(violations=(TIPPED,)))
    before, after = drawn(renderer, broken, 4, 5)
    assert area(before, BROKEN) == 0
    assert area(after, BROKEN) > 30


def test_other_engines_are_seen_as_ghosts(renderer):
    one = drawn(renderer, recording(execution()), 9)[0]
    agreeing = drawn(renderer, recording(execution(), execution("other")), 9)[0]
    parted = drawn(renderer, recording(execution(), execution("other", moved=-0.2)), 9)[0]
    assert changed(one, agreeing) < 20 < 100 < changed(one, parted)


def test_the_swept_region_lies_on_the_floor(renderer):
    space = PROBLEM.scene.workspace
    cells = np.full((40, 40), space.floor + 0.05)
    region = SweptRegion(space.lower[:2], 0.01, cells, space.floor)
    plain = recording(execution())
    swept = replace(plain, plan=replace(plain.plan, region=region))
    assert changed(drawn(renderer, plain, 0)[0], drawn(renderer, swept, 0)[0]) > 200


def test_two_films_can_be_drawn_by_turns(renderer):
    film = recording(execution())
    alone = drawn(renderer, film, 0, 9)
    one, other = renderer.frames(film, [0, 9], SHOT), renderer.frames(film, [9, 0], SHOT)
    mixed = [next(one), next(other), next(one), next(other)]
    assert changed(*alone) > 0
    for image, expected in zip(mixed, (alone[0], alone[1], alone[1], alone[0]), strict=True):
        assert changed(image, expected) == 0


def test_mamo_view_writes_every_kind_of_picture(tmp_path, capsys):
    write_recording(tmp_path / "kept.npz", recording(execution()))
    files = {kind: tmp_path / f"a.{kind}" for kind in ("mp4", "gif", "png")}
    options = ["--mp4", str(files["mp4"]), "--gif", str(files["gif"]), "--still", str(files["png"])]
    with pytest.raises(SystemExit) as ended:
        main(["view", str(tmp_path / "kept.npz"), *options, "--size", "160x120", "--fps", "20"])
    assert ended.value.code == 0, capsys.readouterr().err
    assert files["mp4"].read_bytes()[4:8] == b"ftyp"
    with Image.open(files["gif"]) as gif:
        assert (gif.size, gif.n_frames) == ((160, 120), 5)
    assert Image.open(files["png"]).size == (320, 120)
