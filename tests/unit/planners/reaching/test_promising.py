"""Failed primitives that are worth varying."""

import numpy as np
from mamo_planners.reaching.goals import Goal
from mamo_planners.reaching.primitive import Primitive
from mamo_planners.reaching.promising import Promising


def primitive(x):
    return Primitive(np.full((2, 4), x), Goal(np.zeros(4)), interacts=True)


def rng():
    return np.random.default_rng(0)


def drawn(promising, times=200):
    draw = rng()
    return [float(promising.drawn(draw).start[0]) for _ in range(times)]


def test_none_before_a_failure():
    assert Promising().drawn(rng()) is None


def test_the_longer_it_held_the_likelier():
    promising = Promising()
    promising.failed(primitive(1.0), 0.9)
    promising.failed(primitive(2.0), 0.1)
    counts = drawn(promising)
    assert counts.count(1.0) > 4 * counts.count(2.0) > 0


def test_only_the_best_stay():
    promising = Promising()
    for number in range(20):
        promising.failed(primitive(float(number)), number / 20)
    assert set(drawn(promising)) == {float(n) for n in range(12, 20)}


def test_of_equal_ones_the_later_stay():
    promising = Promising()
    for number in range(20):
        promising.failed(primitive(float(number)), 0.5)
    assert set(drawn(promising)) == {float(n) for n in range(12, 20)}


def test_all_failed_at_once_are_drawn_too():
    promising = Promising()
    promising.failed(primitive(1.0), 0.0)
    assert drawn(promising, 1) == [1.0]
