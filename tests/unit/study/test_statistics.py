"""Statistics against values worked out by hand or taken from the literature."""

import math

import pytest

from mamo_core.study.statistics import (
    geometric_mean_ratio,
    mcnemar,
    par2,
    quantile,
    success_curve,
    wilson,
)


@pytest.mark.parametrize(
    ("successes", "n", "low", "high"),
    [(0, 0, 0.0, 1.0), (0, 10, 0.0, 0.2775), (5, 10, 0.2366, 0.7634), (10, 10, 0.7225, 1.0)],
)
def test_wilson(successes, n, low, high):
    assert wilson(successes, n) == pytest.approx((low, high), abs=1e-4)


def test_wilson_of_newcombe():
    """Newcombe 1998, table I, 81 of 263."""
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=1e-4)


def test_quantile():
    assert quantile([], 0.5) is None
    assert quantile([3.0], 0.9) == 3.0
    assert quantile([1.0, 2.0, 3.0, 4.0], 0.5) == 2.5
    assert quantile([1.0, 2.0, 3.0], 0.9) == pytest.approx(2.8)
    assert quantile([1.0, 2.0], 1.0) == 2.0


@pytest.mark.parametrize(
    ("only_first", "only_second", "p"),
    [
        (0, 0, 1.0),
        (3, 3, 1.0),
        (0, 5, 2 / 2**5),
        (5, 0, 2 / 2**5),
        (1, 9, 2 * (1 + 10) / 2**10),
        (2, 8, 2 * (1 + 10 + 45) / 2**10),
    ],
)
def test_mcnemar(only_first, only_second, p):
    assert mcnemar(only_first, only_second) == pytest.approx(p, rel=1e-12)


def test_mcnemar_of_many_is_the_same_tail():
    assert mcnemar(470, 529) == pytest.approx(mcnemar(529, 470), rel=1e-12)
    assert mcnemar(471, 529) == pytest.approx(0.0714, abs=5e-4)


def test_par2():
    assert par2([], 10.0) is None
    assert par2([1.0, None, 3.0, None], 10.0) == pytest.approx((1 + 20 + 3 + 20) / 4)


def test_success_curve():
    assert success_curve([0.5, 2.0, 9.0], 4, [1.0, 2.0, 10.0]) == [
        (1.0, 0.25),
        (2.0, 0.5),
        (10.0, 0.75),
    ]
    assert success_curve([], 0, [1.0]) == [(1.0, 0.0)]


def test_ratio_of_a_constant_factor_is_certain():
    first = [1.0, 5.0, 0.3]
    ratio, low, high = geometric_mean_ratio(first, [2.0 * s for s in first])
    assert (ratio, low, high) == pytest.approx((2.0, 2.0, 2.0))


def test_ratio_and_its_interval():
    """Logarithms -1 and 1: of two drawn with replacement the mean is -1, 0 or 1."""
    ratio, low, high = geometric_mean_ratio([1.0, 1.0], [math.exp(-1), math.exp(1)])
    assert ratio == pytest.approx(1.0)
    assert (low, high) == pytest.approx((math.exp(-1), math.exp(1)))


def test_the_interval_is_as_wide_as_the_theory_says():
    logs = [((i * 7919) % 100) / 100 for i in range(100)]  # uniform on [0, 1)
    ratio, low, high = geometric_mean_ratio([1.0] * 100, [math.exp(v) for v in logs])
    half = 1.96 * math.sqrt(1 / 12) / 10
    assert math.log(ratio) == pytest.approx(0.495)
    assert math.log(low) == pytest.approx(0.495 - half, abs=0.005)
    assert math.log(high) == pytest.approx(0.495 + half, abs=0.005)


def test_ratio_is_the_same_every_time_and_none_of_nothing():
    pairs = [1.0] * 40, [1.0 + (7 * i) % 40 for i in range(40)]
    assert geometric_mean_ratio(*pairs) == geometric_mean_ratio(*pairs)
    assert geometric_mean_ratio(*pairs, seed=1) != geometric_mean_ratio(*pairs)
    assert geometric_mean_ratio([], []) is None
