"""Which of many things it takes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

Thing = TypeVar("Thing")


def indispensable(
    things: Sequence[Thing], enough: Callable[[Sequence[Thing]], bool]
) -> tuple[Thing, ...] | None:
    """A part of ``things`` that is enough and of which nothing can be spared.

    Of several such parts one without what comes first. None: not even all of them are enough. More
    things must never be less; then few questions are asked (QuickXplain; Junker, AAAI 2004).
    """
    if not enough(things):
        return None
    return () if enough([]) else tuple(_needed([], things, enough, known=True))


def _needed(
    given: Sequence[Thing],
    things: Sequence[Thing],
    enough: Callable[[Sequence[Thing]], bool],
    *,
    known: bool,
) -> list[Thing]:
    """What it takes of ``things`` beside those ``given``, with which all of them are enough.

    ``known``: that those given alone are not enough.
    """
    if not known and enough(given):
        return []
    if len(things) == 1:
        return list(things)
    half = len(things) // 2
    first, last = things[:half], things[half:]
    early = _needed([*given, *last], first, enough, known=False)
    return early + _needed([*given, *early], last, enough, known=not early)
