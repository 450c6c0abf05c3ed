"""Pushes beside the centre: a box that is too wide to get out of the way as it stands is turned."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from functools import lru_cache
from itertools import islice

import numpy as np

from mamo_core.interfaces.action_generator import ActionGenerator, ActionRequest
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array, Box, yaw_of
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Statistics
from mamo_planners.actions.push import Push
from mamo_planners.actions.push_line import PushLine, beside_centre
from mamo_planners.actions.sliding import slid
from mamo_planners.actions.way_out import NEVER, STEP, WayOut, WaysOut
from mamo_planners.options import TurnOptions

_KEPT = 64
"""Ways out that are kept: searches ask again and again for the same objects and regions."""


class Turn(ActionGenerator):
    """Straight pushes that should bring a box nearer to a pose outside the region.

    What a push does to the box alone is foreseen; pushes that should gain most come first. The path
    of a request is not followed: it is for objects that keep their yaw.
    """

    def __init__(
        self, problem: Problem, push: Push, options: TurnOptions, gone: Collection[str] = ()
    ) -> None:
        """``push`` makes motions of lines, of its kind. ``gone``: what boxes do not meet."""
        self._problem, self._push, self._options = problem, push, options
        self._way_out = lru_cache(_KEPT)(WaysOut(problem, gone).of)
        count = max(1, round(options.longest / STEP))
        self._lengths = np.linspace(STEP, count * STEP, count)

    def propose(
        self,
        state: SceneState,
        request: ActionRequest,
        rng: np.random.Generator,
        statistics: Statistics,
    ) -> Iterator[RearrangementAction]:
        name = request.object_name
        number = self._problem.scene.index(name)
        shape = self._problem.scene.objects[number].shape
        if not isinstance(shape, Box):
            return  # what is round looks the same however it is turned
        with statistics.timed("turns"):
            lines = self._lines(state, request.region, number, shape, rng)
        statistics.failed(name, "turn", "no_turn_helps", int(not lines))
        pushes = (
            push
            for line in lines[: self._options.lines]
            for push in self._push.along(state, name, line, rng, statistics)
        )
        yield from islice(pushes, self._options.samples)

    def progress(
        self, before: SceneState, request: ActionRequest
    ) -> Callable[[SceneState], bool] | None:
        number = self._problem.scene.index(request.object_name)
        if not isinstance(self._problem.scene.objects[number].shape, Box):
            return None
        way = self._way_out(number, request.region)
        least = self._left(before, number, way) - self._options.gain
        return lambda after: self._left(after, number, way) <= least

    def without(self, names: Collection[str]) -> ActionGenerator:
        return Turn(self._problem, self._push.without(names), self._options, gone=names)

    def _left(self, state: SceneState, number: int, way: WayOut) -> int:
        return int(way.left(_planar(state.object_poses[number])))

    def _lines(
        self,
        state: SceneState,
        region: SweptRegion,
        number: int,
        shape: Box,
        rng: np.random.Generator,
    ) -> list[PushLine]:
        """Pushes that should gain enough, with the length that gains most; the best ones first.

        Some chance, for other ones when asked again.
        """
        way, pose = self._way_out(number, region), state.object_poses[number]
        lines = beside_centre(shape, pose)
        directions = np.array([line.direction for line in lines])
        contacts = np.array([line.contact for line in lines])
        foreseen = way.left(slid(shape, _planar(pose), contacts, directions, self._lengths))
        # What is foreseen after something immovable was met does not count.
        foreseen = np.maximum.accumulate(np.where(foreseen == NEVER, NEVER, 0), axis=1) + foreseen
        best = foreseen.argmin(axis=1)
        gains = self._left(state, number, way) - foreseen[np.arange(len(lines)), best]
        shares = rng.uniform(self._options.least_share, 1.0, len(lines))
        order = np.argsort(-gains * shares, kind="stable")
        return [
            lines[k].by(float(self._lengths[best[k]]))
            for k in order.tolist()
            if gains[k] >= self._options.gain
        ]


def _planar(pose: Array) -> Array:
    """x, y and yaw of a pose (7,)."""
    return np.array([pose[0], pose[1], yaw_of(pose)])
