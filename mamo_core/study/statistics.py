"""The statistics of success and time."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

SAMPLES = 10_000
_LEAST = 1e-9
"""Seconds; less is not measured."""


def wilson(successes: int, n: int, z: float = 1.959964) -> tuple[float, float]:
    """Wilson's score interval of a share, 95 % by default."""
    if n == 0:
        return 0.0, 1.0
    share = successes / n
    middle = share + z * z / (2 * n)
    half = z * math.sqrt(share * (1 - share) / n + z * z / (4 * n * n))
    scale = 1 + z * z / n
    return max(0.0, (middle - half) / scale), min(1.0, (middle + half) / scale)


def quantile(ordered: Sequence[float], share: float) -> float | None:
    """Quantile of ascending values with linear interpolation; None of nothing."""
    if not ordered:
        return None
    place = share * (len(ordered) - 1)
    low = math.floor(place)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (place - low) * (ordered[high] - ordered[low])


def mcnemar(only_first: int, only_second: int) -> float:
    """Exact two-sided p of McNemar's test: pairs of which only one of two succeeded."""
    n, fewer = only_first + only_second, min(only_first, only_second)
    tail = sum(math.comb(n, k) for k in range(fewer + 1))
    return min(1.0, 2.0 * tail / 2.0**n) if n < 1000 else _large_mcnemar(n, fewer)


def _large_mcnemar(n: int, fewer: int) -> float:
    from scipy.stats import binom

    return min(1.0, 2.0 * float(binom.cdf(fewer, n, 0.5)))


def par2(seconds: Sequence[float | None], budget: float) -> float | None:
    """Mean seconds, where None, a failure, counts twice the budget; None of nothing."""
    if not seconds:
        return None
    return math.fsum(2.0 * budget if s is None else s for s in seconds) / len(seconds)


def success_curve(
    seconds: Sequence[float], n: int, budgets: Sequence[float]
) -> list[tuple[float, float]]:
    """(budget, share of n) where ``seconds`` are those of all that succeeded at last."""
    return [(b, sum(s <= b for s in seconds) / n if n else 0.0) for b in budgets]


def geometric_mean_ratio(
    first: Sequence[float], second: Sequence[float], *, seed: int = 0, samples: int = SAMPLES
) -> tuple[float, float, float] | None:
    """Geometric mean of ``second / first`` over pairs, and its 95 % interval; None without pairs.

    The interval is that of a bootstrap over pairs (percentiles).
    """
    if not first:
        return None
    logs = np.log(np.maximum(second, _LEAST)) - np.log(np.maximum(first, _LEAST))
    rng = np.random.default_rng(seed)
    means = [logs[rng.integers(0, logs.size, logs.size)].mean() for _ in range(samples)]
    low, high = np.quantile(means, (0.025, 0.975))
    return float(np.exp(logs.mean())), float(np.exp(low)), float(np.exp(high))
