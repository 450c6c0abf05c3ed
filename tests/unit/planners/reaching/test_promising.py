"""Failed primitives that are worth varying."""

import numpy as np
from mamo_planners.reaching.goals import Goal
from mamo_planners.reaching.primitive import Primitive
from mamo_planners.reaching.promising import Promising


def primitive(x):
    path = np.full((2, 4), x)
    return Primitive(path, Goal(np.zeros(4)), approach=path[:1], sweep=path)


def rng():
    return np.random.default_rng(0)


def drawn(promising, times=200):
    draw = rng()
    return [float(promising.drawn(draw).start[0]) for _ in range(times)]


def test_none_before_a_failure():
    assert Promising().drawn(rng()) is None


def test_the_closer_it_came_the_likelier():
    promising = Promising()
    promising.failed(primitive(1.0), 0.1)
    promising.failed(primitive(2.0), 3.0)
    counts = drawn(promising)
    assert counts.count(1.0) > 4 * counts.count(2.0) > 0


def test_only_the_best_stay():
    promising = Promising()
    for number in range(20):
        promising.failed(primitive(float(number)), 20.0 - number)
    assert set(drawn(promising)) == {float(n) for n in range(12, 20)}


def test_of_equal_ones_the_later_stay():
    promising = Promising()
    for number in range(20):
        promising.failed(primitive(float(number)), 0.5)
    assert set(drawn(promising)) == {float(n) for n in range(12, 20)}


def test_one_that_failed_at_its_very_end_is_drawn_too():
    promising = Promising()
    promising.failed(primitive(1.0), 0.0)
    assert drawn(promising, 1) == [1.0]
