"""A transition model made of an engine's worlds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.interfaces.simulated_world import SimulatedWorld
from mamo_core.interfaces.transition_model import RolloutOptions, TransitionModel
from mamo_core.robots.model import ArmModel
from mamo_core.simulation.run import MotionRun
from mamo_core.simulation.worlds import WorldFactory, Worlds, same_parameters
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import SceneState


@dataclass(frozen=True, eq=False)
class Continuation:
    """Where a rollout ended: a ``snapshot`` of the world, or how to get there again.

    ``start`` and ``motions`` (each with whether it stops early) are what has been executed, kept
    only without a snapshot. ``parameters``: of the world it happened in.
    """

    parameters: ParameterOverrides | None
    start: SceneState
    motions: tuple[tuple[Motion, bool], ...]
    snapshot: Any
    opening: float
    held: int


class SimulatedModel(TransitionModel):
    """Resets its world before every rollout, so that the result depends on nothing else.

    Worlds without exact snapshots are continued by executing everything again, which gives the
    same bits as every rollout is a function of its arguments.
    """

    def __init__(
        self,
        problem: Problem,
        arm: ArmModel,
        constraints: Sequence[InteractionConstraint],
        make_world: WorldFactory,
    ) -> None:
        self._problem, self._arm, self._constraints = problem, arm, tuple(constraints)
        self._pool = Worlds(make_world)
        # Errors of building the world reach who builds the model.
        with self._pool.borrowed(None):
            pass

    def rollout(
        self,
        state: SceneState,
        motion: Motion,
        *,
        parameters: ParameterOverrides | None = None,
        options: RolloutOptions | None = None,
        continue_from: Any = None,
    ) -> RolloutResult:
        chosen = options if options is not None else RolloutOptions()
        if continue_from is None:
            with self._pool.borrowed(parameters) as world:
                return self._fresh(world, parameters, state, motion, chosen)
        if not isinstance(continue_from, Continuation):
            raise ValueError(
                f"continue_from: {type(continue_from).__name__}, expected what an earlier "
                "rollout gave as its continuation"
            )
        if not same_parameters(parameters, continue_from.parameters):
            raise ValueError("continue_from: cannot be continued with other parameters")
        with self._pool.borrowed(parameters) as world:
            return self._continued(world, state, motion, chosen, continue_from)

    def tool_pose(self, state: SceneState) -> Array:
        with self._pool.borrowed(None) as world:
            world.reset(state, self._arm.gripper.drive(self._arm.gripper.closed))
            return world.tool_pose()

    def _fresh(
        self,
        world: SimulatedWorld,
        parameters: ParameterOverrides | None,
        state: SceneState,
        motion: Motion,
        options: RolloutOptions,
    ) -> RolloutResult:
        world.reset(state, self._arm.gripper.drive(motion.opening))
        run = self._run(world, options, motion.opening)
        result = run.execute(motion, state)
        first = Continuation(parameters, state, (), None, motion.opening, -1)
        return self._kept(world, run, result, first, motion, options)

    def _continued(
        self,
        world: SimulatedWorld,
        state: SceneState,
        motion: Motion,
        options: RolloutOptions,
        before: Continuation,
    ) -> RolloutResult:
        if world.exact_snapshots:
            world.restore(before.snapshot)
        else:
            self._replay(world, before)
        run = self._run(world, options, before.opening, before.held)
        result = run.execute(motion, state)
        return self._kept(world, run, result, before, motion, options)

    def _replay(self, world: SimulatedWorld, before: Continuation) -> None:
        opening, held = before.motions[0][0].opening, -1
        world.reset(before.start, self._arm.gripper.drive(opening))
        for motion, stop_early in before.motions:
            run = self._run(world, RolloutOptions(stop_early=stop_early), opening, held)
            run.execute(motion, before.start)
            opening, held = run.opening, run.held

    def _run(
        self, world: SimulatedWorld, options: RolloutOptions, opening: float, held: int = -1
    ) -> MotionRun:
        scene, gripper = self._problem.scene, self._arm.gripper
        return MotionRun(world, scene, gripper, self._constraints, options, opening, held)

    def _kept(
        self,
        world: SimulatedWorld,
        run: MotionRun,
        result: RolloutResult,
        before: Continuation,
        motion: Motion,
        options: RolloutOptions,
    ) -> RolloutResult:
        """The result with where it ended, if that is wanted."""
        if not options.keep:
            return result
        token = replace(before, opening=run.opening, held=run.held)
        if world.exact_snapshots:
            token = replace(token, snapshot=world.snapshot())
        else:
            token = replace(token, motions=(*before.motions, (motion, options.stop_early)))
        return replace(result, continuation=token)
