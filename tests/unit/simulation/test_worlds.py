"""Worlds are built once, lent to one at a time, and never mixed up."""

import pytest

from mamo_core.simulation.worlds import Worlds
from mamo_core.types.rollout import ParameterOverrides


class World:
    def __init__(self, parameters):
        self.parameters = parameters


@pytest.fixture
def built():
    return []


@pytest.fixture
def worlds(built):
    def make(parameters):
        built.append(World(parameters))
        return built[-1]

    return Worlds(make)


def used(worlds, parameters):
    with worlds.borrowed(parameters) as world:
        return world


def heavy(mass):
    return ParameterOverrides({"can": mass}, {"can": 0.4, "box": 0.5})


def test_the_same_values_get_the_same_world(worlds, built):
    first = used(worlds, heavy(2.0))
    assert used(worlds, heavy(2.0)) is first
    swapped = ParameterOverrides({"can": 2.0}, {"box": 0.5, "can": 0.4})
    assert used(worlds, swapped) is first
    assert len(built) == 1


def test_other_values_get_another_world(worlds):
    nominal = used(worlds, None)
    assert used(worlds, heavy(2.0)) is not nominal
    assert used(worlds, heavy(2.1)) is not used(worlds, heavy(2.0))
    assert used(worlds, ParameterOverrides({"can": 0.4})) is not used(
        worlds, ParameterOverrides({}, {"can": 0.4})
    )
    assert used(worlds, ParameterOverrides()) is not nominal
    assert used(worlds, None) is nominal


def test_two_at_a_time_get_two_worlds(worlds, built):
    with worlds.borrowed(None) as one, worlds.borrowed(None) as other:
        assert one is not other
    with worlds.borrowed(None) as one, worlds.borrowed(None) as other:
        assert {id(one), id(other)} == {id(world) for world in built}


def test_a_dozen_sets_are_kept(worlds, built):
    for _ in range(3):
        for number in range(12):
            used(worlds, heavy(1.0 + number))
    assert len(built) == 12


def test_not_everything_is_kept(worlds, built):
    for number in range(100):
        used(worlds, heavy(1.0 + number))
    used(worlds, heavy(100.0))
    assert len(built) == 100
    used(worlds, heavy(1.0))
    assert len(built) == 101


def test_a_world_that_failed_is_not_used_again(worlds, built):
    with pytest.raises(ZeroDivisionError), worlds.borrowed(None):
        raise ZeroDivisionError
    assert used(worlds, None) is built[1]
