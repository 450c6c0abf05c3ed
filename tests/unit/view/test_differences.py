import numpy as np
import pytest

from mamo_core.view.differences import differences
from mamo_core.view.engines import draw_engines


def test_what_differs_by_more_than_a_millimetre(recording, execution):
    both = recording(execution("a"), execution("b", sideways=0.02), execution("c", sideways=5e-4))
    found = differences(both)
    assert {engine: list(tracks) for engine, tracks in found.items()} == {"b": ["can"], "c": []}
    assert found["b"]["can"] == pytest.approx(np.linspace(0.0, 20.0, len(both.times)))


def test_the_picture_of_engines_shows_when_they_part(recording, execution, tmp_path):
    """A plot in the colours of the engines, below the view from above."""
    from matplotlib.image import imread

    for name, sideways in (("same", 0.0), ("other", 0.02)):
        both = recording(execution("a"), execution("b", sideways=sideways))
        draw_engines(both, tmp_path / f"{name}.png")
    same, other = (
        (imread(tmp_path / f"{name}.png")[950:1250, :, :3] * 255).round()
        for name in ("same", "other")
    )
    red = np.array([0xD6, 0x27, 0x28])
    counts = [int((np.abs(image - red).max(axis=2) < 3).sum()) for image in (same, other)]
    assert counts[0] == 0
    assert counts[1] > 500
