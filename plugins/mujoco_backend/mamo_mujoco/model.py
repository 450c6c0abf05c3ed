"""The MuJoCo transition model."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import mujoco

from mamo_core.constraints.standard import ContactConstraint
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.robots.model import ArmModel
from mamo_core.simulation.model import SimulatedModel
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import SceneState
from mamo_mujoco.engine import MuJoCoWorld
from mamo_mujoco.fingers import FrictionHold
from mamo_mujoco.options import MuJoCoOptions
from mamo_mujoco.own_contacts import is_own
from mamo_mujoco.world import build_model, index_of


class MuJoCoModel(SimulatedModel):
    """MuJoCo in this process; batches run in threads if the options give more than one."""

    def __init__(
        self,
        problem: Problem,
        arm: ArmModel,
        constraints: tuple[InteractionConstraint, ...],
        options: MuJoCoOptions,
    ) -> None:
        clearances = [c.clearance for c in constraints if isinstance(c, ContactConstraint)]
        self._worlds = MuJoCoWorlds(problem, arm, options, max(clearances, default=0.0))
        self._threads = options.batch_threads
        super().__init__(problem, arm, constraints, self._worlds)

    def rollout_batch(
        self,
        states: Sequence[SceneState],
        motions: Sequence[Motion],
        *,
        parameters: Sequence[ParameterOverrides | None] | None = None,
        options: RolloutOptions | None = None,
        continue_from: Sequence[Any] | None = None,
    ) -> list[RolloutResult]:
        """Side by side in threads (the engine lets the interpreter go while it steps)."""
        if self._threads == 1:
            return super().rollout_batch(
                states,
                motions,
                parameters=parameters,
                options=options,
                continue_from=continue_from,
            )
        overrides = parameters if parameters is not None else [None] * len(states)
        tokens = continue_from if continue_from is not None else [None] * len(states)

        def one(job: tuple[SceneState, Motion, ParameterOverrides | None, Any]) -> RolloutResult:
            state, motion, override, token = job
            return self.rollout(
                state, motion, parameters=override, options=options, continue_from=token
            )

        jobs = list(zip(states, motions, overrides, tokens, strict=True))
        with ThreadPoolExecutor(self._threads) as pool:
            return list(pool.map(one, jobs))


class MuJoCoWorlds:
    """Makes worlds of one problem; it is compiled once."""

    def __init__(
        self, problem: Problem, arm: ArmModel, options: MuJoCoOptions, clearance: float
    ) -> None:
        self._problem = problem
        self._lead = options.lead
        self._sleep_at_once = options.sleep and options.sleep_at_once
        self._friction = options.grasp == "friction"
        self._model = build_model(problem, arm, options, clearance)
        self._index = index_of(self._model, problem, arm)

    def __call__(self, parameters: ParameterOverrides | None) -> MuJoCoWorld:
        model = copy.copy(self._model)
        if parameters is not None:
            self._change(model, parameters)
        return MuJoCoWorld(
            self._problem,
            model,
            self._index,
            self._lead,
            sleep_at_once=self._sleep_at_once,
            pads=self._pads(model) if self._friction else None,
        )

    def _pads(self, model: Any) -> FrictionHold:
        return FrictionHold(model, [model.geom(o.name).id for o in self._problem.scene.objects])

    def _change(self, model: Any, parameters: ParameterOverrides) -> None:
        scene = self._problem.scene
        for name, mass in parameters.masses.items():
            scene.index(name)  # the error names the objects there are
            body = model.body(name).id
            model.body_inertia[body] *= mass / model.body_mass[body]
            model.body_mass[body] = mass
        frictions = {o.name: o.friction for o in scene.objects}
        frictions.update((f.name, f.friction) for f in scene.fixtures)
        frictions.update(parameters.frictions)
        for name in parameters.frictions:
            model.geom_friction[model.geom(name).id, 0] = frictions[name]
        pairs = enumerate(model.pair(n).name for n in range(model.npair))
        for pair, name in ((n, name) for n, name in pairs if not is_own(name)):
            one, other = name.split("|")
            model.pair_friction[pair, :2] = frictions[one] * frictions[other]
        mujoco.mj_setConst(model, mujoco.MjData(model))
