"""How well a priority tells rearrangements apart that can and cannot be solved."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import groupby

from mamo_planners.learning.data import Point
from mamo_planners.search.features import Features


def ranked_right(
    points: Sequence[Point], score: Callable[[Features], float]
) -> tuple[float | None, int]:
    """In what share of the pairs, of one solved and one not, the solved one has the higher score.

    Pairs are of the same problem, since a search compares nothing else; a tie counts half. Also
    the number of pairs; without any the share is None. 0.5 is what chance would do.
    """
    right, pairs = 0.0, 0
    for solved, unsolved in _by_problem(points):
        for one in map(score, solved):
            for other in map(score, unsolved):
                right += 1.0 if one > other else 0.5 if one == other else 0.0
                pairs += 1
    return (right / pairs if pairs else None), pairs


def _by_problem(points: Sequence[Point]) -> Iterator[tuple[list[Features], list[Features]]]:
    """Features of the solved and of the others."""
    for _, group in groupby(sorted(points, key=lambda p: p.problem), lambda p: p.problem):
        members = list(group)
        yield (
            [point.features for point in members if point.solved],
            [point.features for point in members if not point.solved],
        )
