"""The parameters of the learned priority by maximum likelihood (thesis 5.5.3)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import digamma, polygamma

from mamo_core.errors import InputError
from mamo_core.types.geometry import Array, BoolArray
from mamo_planners.learning.data import Point
from mamo_planners.search.priority import LEAST_SHARE, PriorityModel

CONFIDENCE = 0.95

_ROUNDS = 100
_PRECISION = 1e-10
_LEAST_VARIANCE = 1e-12

_POINTS, _SOLVED, _LOG, _LOG_REST, _SHARE, _SQUARE, _COUNT, _EFFORTS, _EFFORT = range(9)
"""Sums over the points of a problem; from the third on over the solved ones."""


@dataclass(frozen=True)
class Estimate:
    """A value, and the interval that ``CONFIDENCE`` of the resampled data sets agree on."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Fit:
    """What maximises the likelihood of the solved rearrangements, P(features | solved).

    ``solvable``: share of all that are solved, P(E). ``alpha``, ``beta``: of the occupied share of
    the NGR. ``count_rate`` of the number of objects in it, ``effort_rate`` of mass (kg) x friction
    x share inside of each of these: inverse means of exponential distributions. ``points``,
    ``solved``: rearrangements; ``clear``: solved ones with nothing in the NGR; ``objects``: in the
    NGRs of the solved ones; ``problems``: that have any rearrangement.
    """

    solvable: Estimate
    alpha: Estimate
    beta: Estimate
    count_rate: Estimate
    effort_rate: Estimate
    points: int
    solved: int
    clear: int
    objects: int
    problems: int

    @property
    def model(self) -> PriorityModel:
        """The parameters alone."""
        rates = self.count_rate.value, self.effort_rate.value
        return PriorityModel(self.alpha.value, self.beta.value, *rates)


def fit(points: Sequence[Point], rng: np.random.Generator, resamples: int = 1000) -> Fit:
    """Fit to the solved points; the intervals come from drawing whole problems again.

    Rearrangements of one problem are alike, so that intervals from single points would be too
    narrow. The Beta density is 0 or infinite at a share of 0: a share below ``LEAST_SHARE`` counts
    as that, as it does when the density is evaluated.

    Raises:
        InputError: too little was solved to tell anything.
    """
    sums = _sums_by_problem(points)
    total = sums.sum(axis=0, keepdims=True)
    if not _is_enough(total).all():
        raise InputError(
            f"nothing to fit: {int(total[0, _SOLVED])} of {len(points)} rearrangements are solved, "
            f"with {int(total[0, _COUNT])} objects in the way; expected 2 or more that differ, "
            "with 1 object or more (try more problems)"
        )
    values = _estimates(total)[0]
    drawn = sums[rng.integers(len(sums), size=(resamples, len(sums)))].sum(axis=1)
    others = _estimates(np.concatenate([total, drawn[_is_enough(drawn)]]))
    tail = 50.0 * (1.0 - CONFIDENCE)
    low, high = np.percentile(others, [tail, 100.0 - tail], axis=0)
    solvable, alpha, beta, count_rate, effort_rate = (
        Estimate(float(v), float(a), float(b)) for v, a, b in zip(values, low, high, strict=True)
    )
    solved = [point.features for point in points if point.solved]
    clear = sum(not features.count for features in solved)
    objects = sum(features.count for features in solved)
    return Fit(
        solvable=solvable,
        alpha=alpha,
        beta=beta,
        count_rate=count_rate,
        effort_rate=effort_rate,
        points=len(points),
        solved=len(solved),
        clear=clear,
        objects=objects,
        problems=len(sums),
    )


def beta_by_likelihood(mean_logs: Array, start: Array) -> Array:
    """Alpha and beta (n, 2) from the means (n, 2) of log x and log(1 - x), by Fisher's scoring.

    The likelihood has one maximum. Logarithms are stepped, to stay positive.
    """
    logarithms = np.log(start)
    for _ in range(_ROUNDS):
        values = np.exp(logarithms)
        whole = values.sum(axis=1, keepdims=True)
        slope = mean_logs + digamma(whole) - digamma(values)
        information = polygamma(1, values)[:, None] * np.eye(2) - polygamma(1, whole)[:, None]
        step = np.linalg.solve(information, slope[..., None])[..., 0] / values
        logarithms = logarithms + np.clip(step, -1.0, 1.0)
        if np.abs(step).max() < _PRECISION:
            break
    return np.exp(logarithms)


def _sums_by_problem(points: Sequence[Point]) -> Array:
    """One row of sums (9,) for each problem."""
    sums: defaultdict[int, Array] = defaultdict(lambda: np.zeros(9))
    for point in points:
        row = sums[point.problem]
        row[_POINTS] += 1
        if point.solved:
            share = min(max(point.features.occupied, LEAST_SHARE), 1.0 - LEAST_SHARE)
            efforts = point.features.efforts
            logs = np.log(share), np.log1p(-share)
            row[1:] += (1, *logs, share, share**2, point.features.count, len(efforts), sum(efforts))
    return np.array([sums[problem] for problem in sorted(sums)]).reshape(-1, 9)


def _is_enough(totals: Array) -> BoolArray:
    """Whether the sums (n, 9) determine all parameters."""
    some = np.maximum(totals[:, _SOLVED], 1.0)
    variance = totals[:, _SQUARE] / some - (totals[:, _SHARE] / some) ** 2
    return (totals[:, _COUNT] > 0) & (variance > _LEAST_VARIANCE)


def _estimates(totals: Array) -> Array:
    """Solvable, alpha, beta, rate of counts, rate of efforts (n, 5) from sums (n, 9)."""
    solved = totals[:, [_SOLVED]]
    mean, square = (totals[:, [_SHARE, _SQUARE]] / solved).T
    moments = np.stack([mean, 1.0 - mean], axis=1)
    start = moments * (mean * (1.0 - mean) / (square - mean**2) - 1.0)[:, None]
    shares = beta_by_likelihood(totals[:, [_LOG, _LOG_REST]] / solved, start)
    others = (
        solved[:, 0] / totals[:, _POINTS],
        solved[:, 0] / totals[:, _COUNT],
        totals[:, _EFFORTS] / totals[:, _EFFORT],
    )
    return np.stack([others[0], *shares.T, *others[1:]], axis=1)
