"""Keeps worlds that have been built, as building one takes milliseconds."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager

from mamo_core.interfaces.simulated_world import SimulatedWorld
from mamo_core.types.rollout import ParameterOverrides

WorldFactory = Callable[[ParameterOverrides | None], SimulatedWorld]
"""A new world, with other masses and frictions if some are given."""

_KEPT = 16
"""Idle worlds that are kept: a robust search asks for the same dozen again and again."""


class Worlds:
    """Lends the worlds of one problem; each is used by one borrower at a time.

    Rollouts begin with a reset or a restored snapshot, so that it does not matter which world of
    the same masses and frictions they get.
    """

    def __init__(self, make_world: WorldFactory) -> None:
        self._make_world = make_world
        self._lock = threading.Lock()
        self._idle: list[tuple[Hashable, SimulatedWorld]] = []
        """The least recently used first."""

    @contextmanager
    def borrowed(self, parameters: ParameterOverrides | None) -> Iterator[SimulatedWorld]:
        """A world with these masses and frictions; one that raised an error is not kept."""
        key = _key(parameters)
        world = self._take(key) or self._make_world(parameters)
        yield world
        with self._lock:
            self._idle = [*self._idle, (key, world)][-_KEPT:]

    def _take(self, key: Hashable) -> SimulatedWorld | None:
        with self._lock:
            place = next((i for i, (other, _) in enumerate(self._idle) if other == key), None)
            return None if place is None else self._idle.pop(place)[1]


def same_parameters(one: ParameterOverrides | None, other: ParameterOverrides | None) -> bool:
    """Whether both change the same masses and frictions to the same values."""
    return _key(one) == _key(other)


def _key(parameters: ParameterOverrides | None) -> Hashable:
    if parameters is None:
        return None
    return frozenset(parameters.masses.items()), frozenset(parameters.frictions.items())
