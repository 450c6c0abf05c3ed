"""Rollouts of the engines that execute a plan, counted and charged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.types.motion import Motion
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Budget, Statistics
from mamo_planners.search.stand import Line

KEEP = RolloutOptions(keep=True)
"""So that the execution can go on from there."""


class Rollouts:
    """Asks the engines; what runs outside this process is charged to the budget, too."""

    def __init__(self, statistics: Statistics, budget: Budget) -> None:
        self._stats, self._budget = statistics, budget

    def one(self, line: Line, motion: Motion, options: RolloutOptions | None) -> RolloutResult:
        """What happens when an engine goes on with ``motion`` from where it stands."""
        state, executed = _job(line, motion)
        self._stats.counts["rollouts"] += 1
        with self._stats.timed("rollouts"):
            result = line.engine.model.rollout(
                state,
                executed,
                parameters=line.engine.parameters,
                options=options,
                continue_from=line.token,
            )
        self._charge(result)
        return result

    def from_rest(self, line: Line, motion: Motion) -> RolloutResult:
        """What happens when an engine executes all of ``motion`` from rest."""
        begin = line.state.with_joints(motion.start)
        whole = replace(line, engine=replace(line.engine, continuous=True), state=begin, token=None)
        return self.one(whole, motion, None)

    def side_by_side(self, lines: Sequence[Line], motion: Motion) -> list[RolloutResult]:
        """The same for several lines of one model."""
        if len(lines) == 1:
            return [self.one(lines[0], motion, None)]
        jobs = [_job(line, motion) for line in lines]
        self._stats.counts["rollouts"] += len(lines)
        with self._stats.timed("rollouts"):
            results = lines[0].engine.model.rollout_batch(
                [state for state, _ in jobs],
                [executed for _, executed in jobs],
                parameters=[line.engine.parameters for line in lines],
                continue_from=[line.token for line in lines],
            )
        for result in results:
            self._charge(result)
        return results

    def _charge(self, result: RolloutResult) -> None:
        self._stats.charge("rollouts", result.outside_cpu)
        self._budget.charge(result.outside_cpu)


def _job(line: Line, motion: Motion) -> tuple[SceneState, Motion]:
    """What an engine executes, and from where."""
    if line.engine.continuous:
        return line.state, motion
    sweep = motion.after_transit()
    return line.state.with_joints(sweep.start), sweep
