"""The picture of a scene without a plan: who is outlined, and that long texts stay inside."""

from pathlib import Path

import numpy as np
import pytest

from mamo_core.problems import generate_shelf
from mamo_core.view.failure import INVOLVED, SUBJECT, draw_failure

PROBLEM = generate_shelf(movables=4, seed=0)
MOVABLE = PROBLEM.scene.objects[PROBLEM.scene.movable_indices[0]].name


def drawn(path: Path, **changes) -> np.ndarray:
    from matplotlib.image import imread

    values = {"headline": "it is so", "subjects": (), "involved": (), "rows": ()}
    draw_failure(PROBLEM, path, **{**values, **changes})
    return (imread(path)[:, :, :3] * 255).round().astype(int)


def count(image: np.ndarray, color: str) -> int:
    rgb = [int(color[i : i + 2], 16) for i in (1, 3, 5)]
    return int((np.abs(image - rgb).max(axis=2) <= 2).sum())


@pytest.fixture(scope="module")
def nobody(tmp_path_factory):
    """The legend alone has the colours."""
    return drawn(tmp_path_factory.mktemp("nobody") / "p.png")


@pytest.mark.parametrize("name", [MOVABLE, PROBLEM.scene.fixtures[0].name])
def test_objects_and_fixtures_are_outlined(nobody, tmp_path, name):
    for key, color in (("subjects", SUBJECT), ("involved", INVOLVED)):
        image = drawn(tmp_path / "p.png", **{key: (name,)})
        assert count(image, color) > count(nobody, color) + 200


def test_names_that_are_no_bodies_are_left_out(nobody, tmp_path):
    assert (drawn(tmp_path / "p.png", subjects=("robot",)) == nobody).all()


def test_many_long_rows_leave_the_scene_where_it_is(nobody, tmp_path):
    rows = [("an_object_with_a_name", "some_action", 10**6, "why it failed, at length " * 9)] * 40
    image = drawn(tmp_path / "p.png", rows=rows)
    half = image.shape[1] // 2 - 20
    assert (image[150:-150, :half] == nobody[150:-150, :half]).all()
    assert (image != nobody).any()
