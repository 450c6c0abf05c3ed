"""Fitting gives back the parameters that data were drawn with."""

from dataclasses import replace

import numpy as np
import pytest
from mamo_planners.learning.data import Data, Point
from mamo_planners.learning.fit import beta_by_likelihood, fit
from mamo_planners.learning.ranking import ranked_right
from mamo_planners.learning.report import report_of
from mamo_planners.search.features import Features
from mamo_planners.search.options import BestFirstOptions
from scipy.stats import beta

from mamo_core.config import load_text
from mamo_core.errors import InputError

ALPHA, BETA, COUNT_RATE, EFFORT_RATE = 2.0, 30.0, 0.5, 20.0
EMPTY = Features(0.0, 0, ())


def drawn(count, rng, problems=40):
    """Solved points of the model itself, counts rounded up so that no share is alone."""
    points = []
    for number in range(count):
        objects = int(np.floor(rng.exponential(1.0 / COUNT_RATE) + 0.5))
        efforts = tuple(rng.exponential(1.0 / EFFORT_RATE, objects))
        features = Features(float(rng.beta(ALPHA, BETA)), objects, efforts)
        points.append(Point(number % problems, number, 0, features, True))
    return points


def test_known_parameters_are_found_again():
    found = fit(drawn(4000, np.random.default_rng(0)), np.random.default_rng(0), resamples=200)
    for estimate, true in (
        (found.alpha, ALPHA),
        (found.beta, BETA),
        (found.count_rate, COUNT_RATE),
        (found.effort_rate, EFFORT_RATE),
    ):
        assert estimate.value == pytest.approx(true, rel=0.06)
        assert estimate.low < estimate.value < estimate.high
        assert estimate.low < 1.02 * true
        assert estimate.high > 0.98 * true
    assert (found.points, found.solved, found.problems) == (4000, 4000, 40)
    assert found.solvable.value == found.solvable.low == 1.0


def test_intervals_are_wider_with_fewer_problems():
    points = drawn(600, np.random.default_rng(1))
    same_again = [replace(point, vertex=point.vertex + 600) for point in points]

    def width(some):
        alpha = fit(some, np.random.default_rng(0), resamples=200).alpha
        return alpha.high - alpha.low

    # Problems twice as large tell nothing more; twice as many would.
    assert width([*points, *same_again]) == pytest.approx(width(points))
    more = [replace(point, problem=point.problem + 40) for point in same_again]
    assert width([*points, *more]) < 0.9 * width(points)


@pytest.mark.parametrize(("a", "b"), [(0.3, 45.0), (1.0, 1.0), (5.0, 2.0)])
def test_beta_agrees_with_scipy(a, b):
    shares = np.clip(beta.rvs(a, b, size=500, random_state=0), 1e-4, 1 - 1e-4)
    logs = np.array([[np.log(shares).mean(), np.log1p(-shares).mean()]] * 2)
    found = beta_by_likelihood(logs, np.array([[1.0, 1.0], [0.1, 100.0]]))
    expected = beta.fit(shares, floc=0.0, fscale=1.0)[:2]
    np.testing.assert_allclose(found, [expected] * 2, rtol=1e-3)


def test_a_clear_region_counts_as_the_least_share():
    points = drawn(200, np.random.default_rng(2))
    clear = [Point(1, 1000 + n, 1, EMPTY, True) for n in range(20)]
    least = [replace(p, features=replace(EMPTY, occupied=1e-4)) for p in clear]
    one, other = (
        fit([*points, *more], np.random.default_rng(0), resamples=5) for more in (clear, least)
    )
    assert one == other
    assert one.clear >= 20
    assert one.alpha.value < fit(points, np.random.default_rng(0), resamples=5).alpha.value


def test_what_is_not_solved_changes_the_prior_alone():
    points = drawn(100, np.random.default_rng(3))
    hard = [
        replace(p, vertex=p.vertex + 100, features=Features(0.9, 5, (1.0,) * 5), solved=False)
        for p in points
    ]
    one, other = (
        fit(some, np.random.default_rng(0), resamples=5) for some in (points, points + hard)
    )
    assert one.model == other.model
    assert (one.solvable.value, other.solvable.value) == (1.0, 0.5)


@pytest.mark.parametrize(
    "points",
    [
        [],
        [Point(0, 0, 0, Features(0.1, 1, (0.1,)), False)],
        [Point(0, n, 0, EMPTY, True) for n in range(5)],
        [Point(0, 0, 0, Features(0.1, 1, (0.1,)), True)],
    ],
)
def test_too_little_to_fit(points):
    with pytest.raises(InputError, match=r"nothing to fit: \d of \d rearrangements are solved"):
        fit(points, np.random.default_rng(0))


def test_ranking_compares_within_a_problem():
    def point(problem, vertex, share, solved):
        return Point(problem, vertex, 0, Features(share, 1, (0.1,)), solved)

    points = [
        point(0, 0, 0.1, True),
        point(0, 1, 0.2, False),
        point(1, 0, 0.5, True),
        point(1, 1, 0.4, False),
        point(1, 2, 0.5, False),
        point(2, 0, 0.9, True),
    ]
    assert ranked_right(points, lambda f: -f.occupied) == (pytest.approx(1.5 / 3), 3)
    assert ranked_right(points[:1], lambda f: 0.0) == (None, 0)


def test_the_part_of_a_recipe_is_one(tmp_path):
    points = drawn(100, np.random.default_rng(0))
    found = fit(points, np.random.default_rng(0), resamples=5)
    report = report_of("mamo learn-priority", Data(tmp_path), found, points)
    search = load_text(report.recipe_part(), "part").data["search"]
    assert search.pop("name") == "best_first"
    options = BestFirstOptions(**search)
    assert options.alpha == pytest.approx(found.alpha.value, rel=1e-5)
    assert report.document()["search"] == {"name": "best_first", **search}
    assert [row[0] for row in report.rows()] == [*search, "solvable"]
