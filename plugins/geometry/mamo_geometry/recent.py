"""Results that are asked for again soon."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

Value = TypeVar("Value")


class Recent(Generic[Value]):
    """Keeps the values that were asked for last, of a function of the key: at most ``most``."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._kept: dict[Hashable, Value] = {}

    def get(self, key: Hashable, make: Callable[[], Value]) -> Value:
        """The value for ``key``, made if it is not there."""
        if key in self._kept:
            value = self._kept.pop(key)
        else:
            value = make()
            if len(self._kept) == self._most:
                del self._kept[next(iter(self._kept))]
        self._kept[key] = value
        return value
