"""Films of recordings by a renderer that needs nothing: a colour that tells the row."""

import sys

import numpy as np
import pytest
from PIL import Image

from mamo_core.errors import PluginError
from mamo_core.interfaces.renderer import Renderer
from mamo_core.testing.transition_cases import gantry_cases
from mamo_core.types.action import RearrangementAction
from mamo_core.types.recording import RecordedExecution, Recording
from mamo_core.types.rollout import Violation
from mamo_core.types.solution import Plan
from mamo_core.view.captions import broken_by_then, caption, engines
from mamo_core.view.replay import Film, rows_of, write_gif, write_mp4, write_still

CASES = gantry_cases()
PUSH = CASES.push
PLAN = Plan((RearrangementAction("push", "can", PUSH, np.zeros((2, 2))),), PUSH)
TIPPED = Violation("tilt", "can", None, 1.0, 0.6, 0.4)
FILM = Film(fps=10.0, width=120, height=80)


class Painter(Renderer):
    def __init__(self):
        self.rows = []

    def frames(self, recording, rows, shot):
        for row in rows:
            self.rows.append(row)
            yield np.full((shot.height, shot.width, 3), row, dtype=np.uint8)


def recording(*violations, engines=("mujoco",)):
    """Two motions of one second each, 50 rows a second."""
    times = 0.02 * np.arange(101)
    segments = np.minimum(times * len(PUSH.segments), 2 * len(PUSH.segments) - 1).astype(int)
    poses = np.repeat(CASES.problem.initial.object_poses[None], 101, axis=0)
    entities = len(CASES.problem.scene.entities)
    tracks = (np.zeros((101, 4)), np.zeros(101), poses, np.zeros((101, entities, entities), bool))
    executions = tuple(RecordedExecution(name, *tracks, violations) for name in engines)
    return Recording(CASES.problem, PLAN, times, segments, executions)


def test_rows_go_from_the_first_to_the_last_one():
    assert rows_of(recording(), FILM).tolist() == [*range(0, 100, 5), 100]


def test_twice_as_fast_are_half_as_many():
    fast = Film(fps=10.0, width=120, height=80, speed=2.0)
    assert rows_of(recording(), fast).tolist() == [*range(0, 100, 10), 100]


def test_captions_tell_action_and_time():
    assert caption(recording(), 0) == "1/2  push can   0.0 s"
    assert caption(recording(), 100) == "2/2  retrieve   2.0 s"


def test_what_broke_is_told_from_then_on_and_once():
    broken = recording(TIPPED, TIPPED, Violation("contact", "arm", "box", 1.5, 1.0, 0.0))
    assert broken_by_then(broken, 49) == ()
    assert broken_by_then(broken, 50) == ("tilt: can",)
    assert broken_by_then(broken, 100) == ("tilt: can", "contact: arm, box")


def test_several_engines_are_named():
    assert engines(recording()) == ""
    assert engines(recording(engines=("a", "b", "c"))) == "a (as ghosts: b, c)"


def test_a_gif_has_a_picture_for_every_row_and_waits_at_the_end(tmp_path):
    painter = Painter()
    write_gif(tmp_path / "a.gif", recording(TIPPED), painter, FILM)
    assert painter.rows[-21:] == [*range(0, 100, 5), 100]
    with Image.open(tmp_path / "a.gif") as gif:
        assert (gif.size, gif.n_frames) == ((120, 80), 21)
        assert gif.info["duration"] == 100
        gif.seek(20)
        assert gif.info["duration"] == 1100


def test_a_video_plays_as_long_as_the_plan_and_a_second(tmp_path):
    from imageio_ffmpeg import count_frames_and_secs

    write_mp4(tmp_path / "a.mp4", recording(), Painter(), FILM)
    assert count_frames_and_secs(tmp_path / "a.mp4")[0] == 21 + 10


def test_nothing_is_written_where_nothing_can_draw(tmp_path):
    class Blind(Renderer):
        def frames(self, recording, rows, shot):
            raise PluginError("no OpenGL")
            yield

    with pytest.raises(PluginError, match="no OpenGL"):
        write_mp4(tmp_path / "a.mp4", recording(), Blind(), FILM)
    assert not list(tmp_path.iterdir())


def test_a_missing_encoder_is_named_with_its_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(PluginError, match=r"imageio_ffmpeg.*pip install 'mamo\[view\]'"):
        write_mp4(tmp_path / "a.mp4", recording(), Painter(), FILM)


def test_a_still_shows_start_and_end_and_what_broke(tmp_path):
    painter = Painter()
    write_still(tmp_path / "whole.png", recording(), painter, FILM)
    write_still(tmp_path / "broken.png", recording(TIPPED), painter, FILM)
    whole, broken = (
        np.asarray(Image.open(tmp_path / f"{name}.png")).astype(int) for name in ("whole", "broken")
    )
    assert painter.rows == [0, 100, 0, 100]
    assert whole.shape == (80, 240, 3)
    assert (whole[:, :120] == broken[:, :120]).all()
    assert (broken[..., 0] - broken[..., 1]).max() > 100 > (whole[..., 0] - whole[..., 1]).max()
