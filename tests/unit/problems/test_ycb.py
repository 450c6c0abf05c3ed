from __future__ import annotations

import re

import pytest

from mamo_core.problems.ycb import CATALOGUE
from mamo_core.types.geometry import Box, Cylinder
from mamo_core.types.scene import MINIMUM_MASS


def test_ids_are_those_of_the_set() -> None:
    ids = [item.id for item in CATALOGUE]
    assert len(set(ids)) == len(ids) >= 12
    assert ids == sorted(ids)
    assert all(re.fullmatch(r"\d{3}(_[a-z]+)+", ident) for ident in ids)


def test_sizes_and_masses_are_in_si_units() -> None:
    items = {item.name: item for item in CATALOGUE}
    cracker, soup = items["cracker_box"], items["tomato_soup_can"]
    assert isinstance(cracker.shape, Box)
    assert cracker.shape.size.tolist() == [0.060, 0.158, 0.210]
    assert cracker.mass == 0.411
    assert isinstance(soup.shape, Cylinder)
    assert (soup.shape.radius, soup.shape.height) == (0.033, 0.101)


@pytest.mark.parametrize("item", CATALOGUE, ids=lambda item: item.id)
def test_objects_can_stand_in_both_workspaces(item) -> None:
    assert MINIMUM_MASS < item.mass < 1.2
    assert 0.05 <= item.shape.height <= 0.25
    assert item.shape.footprint_radius < 0.1
