"""The MuJoCo transition model."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import mujoco

from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.interfaces.transition_model import RolloutOptions, TransitionModel
from mamo_core.robots.model import ArmModel
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import SceneState
from mamo_mujoco.engine import Continuation, Engine
from mamo_mujoco.options import MuJoCoOptions
from mamo_mujoco.world import build_model, index_of


class MuJoCoModel(TransitionModel):
    """Resets and writes before every rollout, so that the result depends on nothing else."""

    def __init__(
        self,
        problem: Problem,
        arm: ArmModel,
        constraints: tuple[InteractionConstraint, ...],
        options: MuJoCoOptions,
    ) -> None:
        self._problem, self._arm, self._constraints = problem, arm, constraints
        self._options = options
        self._model = build_model(problem, arm, options)
        self._index = index_of(self._model, problem, arm)
        self._engine = self._engine_for(self._model)

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
        if continue_from is not None and not isinstance(continue_from, Continuation):
            raise ValueError(
                f"continue_from: {type(continue_from).__name__}, expected a continuation of mujoco"
            )
        if parameters is not None:
            engine = self._engine_for(self._with(parameters))
            return engine.run(state, motion, chosen, continue_from, keep=False)
        return self._engine.run(state, motion, chosen, continue_from, keep=chosen.keep)

    def rollout_batch(
        self,
        states: Sequence[SceneState],
        motions: Sequence[Motion],
        *,
        parameters: Sequence[ParameterOverrides | None] | None = None,
        options: RolloutOptions | None = None,
    ) -> list[RolloutResult]:
        """Side by side in threads (the engine lets the interpreter go while it steps)."""
        overrides = parameters if parameters is not None else [None] * len(states)
        chosen = options if options is not None else RolloutOptions()

        def one(job: tuple[SceneState, Motion, ParameterOverrides | None]) -> RolloutResult:
            state, motion, override = job
            model = copy.copy(self._model) if override is None else self._with(override)
            return self._engine_for(model).run(state, motion, chosen, None, keep=False)

        jobs = list(zip(states, motions, overrides, strict=True))
        with ThreadPoolExecutor(self._options.batch_threads) as pool:
            return list(pool.map(one, jobs))

    def _engine_for(self, model: Any) -> Engine:
        lead = self._options.damping / self._options.stiffness
        return Engine(self._problem, self._arm, model, self._index, self._constraints, lead)

    def _with(self, parameters: ParameterOverrides) -> Any:
        """A copy of the model with other masses and frictions."""
        model = copy.copy(self._model)
        for name, mass in parameters.masses.items():
            body = self._body(model, name)
            model.body_inertia[body] *= mass / model.body_mass[body]
            model.body_mass[body] = mass
        frictions = {o.name: o.friction for o in self._problem.scene.objects}
        frictions.update(parameters.frictions)
        for name in parameters.frictions:
            model.geom_friction[model.geom(name).id, 0] = frictions[name]
        for pair in range(model.npair):
            one, other = model.pair(pair).name.split("|")
            model.pair_friction[pair, :2] = frictions[one] * frictions[other]
        mujoco.mj_setConst(model, mujoco.MjData(model))
        return model

    def _body(self, model: Any, name: str) -> int:
        self._problem.scene.index(name)
        return int(model.body(name).id)
