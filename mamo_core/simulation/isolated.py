"""Engines in worker processes: a crash or a hang loses one rollout, never the planner."""

from __future__ import annotations

import multiprocessing
import time
import weakref
from collections.abc import Callable, Sequence
from concurrent.futures import Future, TimeoutError
from dataclasses import replace
from typing import Any

from pebble import ProcessExpired, ProcessPool

from mamo_core.interfaces.transition_model import RolloutOptions, TransitionModel
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import SceneState

ModelFactory = Callable[[], TransitionModel]

_model: TransitionModel | None = None
"""The model of a worker process, made when the worker starts."""


class IsolatedModel(TransitionModel):
    """Runs a model in ``workers`` processes that stay alive and are replaced when they die.

    ``make_model`` builds it in each of them and must be picklable. A rollout that takes more than
    ``patience`` seconds of wall time has hung: its worker is killed.
    """

    def __init__(self, make_model: ModelFactory, workers: int, patience: float) -> None:
        self._patience = patience
        self._pool = ProcessPool(
            max_workers=workers,
            context=multiprocessing.get_context("spawn"),
            initializer=_start,
            initargs=[make_model],
        )
        # Also at the end of the interpreter, and when a planner for another problem takes over.
        self.close = weakref.finalize(self, _end, self._pool)
        """Ends the workers; the model cannot be used afterwards."""

    def rollout(
        self,
        state: SceneState,
        motion: Motion,
        *,
        parameters: ParameterOverrides | None = None,
        options: RolloutOptions | None = None,
        continue_from: Any = None,
    ) -> RolloutResult:
        return self._result(state, self._job(state, motion, parameters, options, continue_from))

    def tool_pose(self, state: SceneState) -> Array:
        return self._pool.schedule(_tool_pose, args=[state], timeout=self._patience).result()

    def rollout_batch(
        self,
        states: Sequence[SceneState],
        motions: Sequence[Motion],
        *,
        parameters: Sequence[ParameterOverrides | None] | None = None,
        options: RolloutOptions | None = None,
    ) -> list[RolloutResult]:
        """Side by side in the workers."""
        overrides = parameters if parameters is not None else [None] * len(states)
        jobs = [
            self._job(state, motion, override, options, None)
            for state, motion, override in zip(states, motions, overrides, strict=True)
        ]
        return [self._result(state, job) for state, job in zip(states, jobs, strict=True)]

    def _job(self, *arguments: Any) -> Future[RolloutResult]:
        return self._pool.schedule(_rollout, args=arguments, timeout=self._patience)

    def _result(self, state: SceneState, job: Future[RolloutResult]) -> RolloutResult:
        try:
            return job.result()
        except ProcessExpired as error:
            return _lost(state, f"the engine's process died (exit code {error.exitcode})")
        except TimeoutError:
            return _lost(state, f"the engine gave no answer for {self._patience:g} s")


def isolated(make_model: ModelFactory, workers: int, patience: float) -> TransitionModel:
    """The model in ``workers`` processes, or with 0 workers in this one."""
    return IsolatedModel(make_model, workers, patience) if workers else make_model()


def _end(pool: ProcessPool) -> None:
    pool.stop()
    pool.join()


def _start(make_model: ModelFactory) -> None:
    global _model
    _model = make_model()


def _tool_pose(state: SceneState) -> Array:
    assert _model is not None, "the worker was not started by IsolatedModel"
    return _model.tool_pose(state)


def _rollout(
    state: SceneState,
    motion: Motion,
    parameters: ParameterOverrides | None,
    options: RolloutOptions | None,
    continue_from: Any,
) -> RolloutResult:
    assert _model is not None, "the worker was not started by IsolatedModel"
    started = time.process_time()
    result = _model.rollout(
        state, motion, parameters=parameters, options=options, continue_from=continue_from
    )
    return replace(result, outside_cpu=time.process_time() - started)


def _lost(state: SceneState, why: str) -> RolloutResult:
    return RolloutResult(state, (), (), frozenset(), False, 0.0, 0, lost=why)
