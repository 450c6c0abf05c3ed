"""The states a search over the lattice has found, and the way that led to each."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Generic, TypeVar

import numpy as np

from mamo_core.types.geometry import Array

Key = TypeVar("Key", bound=Hashable)


class Explored(Generic[Key]):
    """States by number, in the order in which they were found.

    ``keys`` tell states apart; ``configurations`` (dof,); ``costs``: primitives from the start.
    """

    def __init__(self) -> None:
        self.keys: list[Key] = []
        self.configurations: list[Array] = []
        self.costs: list[float] = []
        self._parents: list[int] = []
        self._numbers: dict[Key, int] = {}

    def __contains__(self, key: Key) -> bool:
        return key in self._numbers

    def add(self, key: Key, configuration: Array, parent: int) -> int:
        """A new state, one primitive after ``parent`` (-1: the start); its number."""
        number = len(self.keys)
        self._numbers[key] = number
        self.keys.append(key)
        self.configurations.append(configuration)
        self.costs.append(self.costs[parent] + 1.0 if parent >= 0 else 0.0)
        self._parents.append(parent)
        return number

    def ancestry(self, state: int) -> list[int]:
        """Numbers of the states from the start to this one."""
        numbers = []
        while state >= 0:
            numbers.append(state)
            state = self._parents[state]
        return numbers[::-1]

    def way(self, state: int) -> Array:
        """Configurations (k, dof) from the start."""
        return np.array([self.configurations[number] for number in self.ancestry(state)])
