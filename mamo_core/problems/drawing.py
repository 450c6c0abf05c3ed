"""Drawing scenes until one fits."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mamo_core.errors import InputError
from mamo_core.types.problem import Problem

Classify = Callable[[Problem], int | None]
"""Movables that the canonical retrieval or reach of a problem would hit, or None if the target
cannot be reached even without movables."""


def first_fitting(
    name: str,
    draw: Callable[[], Problem],
    classify: Classify | None,
    wanted: Callable[[int], bool],
    max_draws: int,
) -> Problem:
    """The first drawn problem whose number of movables in the way is ``wanted``.

    Without ``classify`` that is the first. ``name`` is what complaints begin with.

    Raises:
        InputError: none of ``max_draws`` problems fits; the text counts what was found.
    """
    found: list[int | None] = []
    for _ in range(max_draws):
        problem = draw()
        if classify is None:
            return problem
        in_the_way = classify(problem)
        if in_the_way is not None and wanted(in_the_way):
            return problem
        found.append(in_the_way)
    raise InputError(
        f"{name}: none of {max_draws} scenes fits (movables in the way, by scene: "
        f"{_tally(found)}); try another seed or number of movables"
    )


def _tally(found: Sequence[int | None]) -> str:
    counts = {n: found.count(n) for n in sorted(set(found), key=lambda n: -1 if n is None else n)}
    return ", ".join(
        f"{'target out of reach' if n is None else n} x{count}" for n, count in counts.items()
    )
