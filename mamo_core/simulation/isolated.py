"""Engines in worker processes: a crash or a hang loses one rollout, never the planner."""

from __future__ import annotations

import multiprocessing
import time
import weakref
from collections.abc import Callable, Sequence
from concurrent.futures import Future, TimeoutError
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from itertools import cycle
from typing import Any, cast

from pebble import ProcessExpired, ProcessPool

from mamo_core.errors import WorkerCrashedError
from mamo_core.interfaces.transition_model import RolloutOptions, TransitionModel
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import SceneState

ModelFactory = Callable[[], TransitionModel]

_START_UP = 120.0
"""Wall time (s) that a new worker may take, on a busy machine, before its first answer."""


class IsolatedModel(TransitionModel):
    """Runs a model in ``workers`` processes that stay alive and are replaced when they die.

    ``make_model`` builds it in each of them and must be picklable. A rollout that takes more than
    ``patience`` seconds of wall time has hung: its worker is killed.
    """

    def __init__(self, make_model: ModelFactory, workers: int, patience: float) -> None:
        self._workers = [_Worker(make_model, patience) for _ in range(workers)]
        # Also at the end of the interpreter, and when a planner for another problem takes over.
        self.close = weakref.finalize(self, _close, self._workers)
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
        worker = self._workers[0]
        job = worker.begin(_rollout, (state, motion, parameters, options, continue_from))
        return _result(worker, job, state)

    def tool_pose(self, state: SceneState) -> Array:
        worker = self._workers[0]
        try:
            return cast(Array, worker.end(worker.begin(_tool_pose, (state,))))
        except _LostError as error:
            raise WorkerCrashedError(f"tool pose: {error}") from error

    def rollout_batch(
        self,
        states: Sequence[SceneState],
        motions: Sequence[Motion],
        *,
        parameters: Sequence[ParameterOverrides | None] | None = None,
        options: RolloutOptions | None = None,
        continue_from: Sequence[Any] | None = None,
    ) -> list[RolloutResult]:
        """Side by side in the workers."""
        overrides = parameters if parameters is not None else [None] * len(states)
        tokens = continue_from if continue_from is not None else [None] * len(states)
        jobs = [
            (worker, worker.begin(_rollout, (state, motion, override, options, token)))
            for worker, state, motion, override, token in zip(
                cycle(self._workers), states, motions, overrides, tokens, strict=False
            )
        ]
        return [_result(*job, state) for job, state in zip(jobs, states, strict=True)]


def isolated(make_model: ModelFactory, workers: int, patience: float) -> TransitionModel:
    """The model in ``workers`` processes, or with 0 workers in this one."""
    return IsolatedModel(make_model, workers, patience) if workers else make_model()


def _close(workers: Sequence[_Worker]) -> None:
    for worker in workers:
        worker.close()


class _LostError(Exception):
    """Why there is no answer."""


@dataclass(eq=False)
class _Job:
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    pool: ProcessPool
    future: Future[Any]
    repeated: bool = False


class _Worker:
    """One process, whose jobs run in the order of ``begin``; ``end`` waits for one.

    It has a pool of its own: a process that is killed while it waits for work breaks the pool it
    belongs to, and with it the work of all others there.
    """

    def __init__(self, make_model: ModelFactory, patience: float) -> None:
        self._make_model, self._patience = make_model, patience
        self._pool = self._new_pool()

    def begin(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> _Job:
        try:
            future = self._pool.schedule(function, args=arguments, timeout=self._patience)
        except RuntimeError:  # the pool is broken
            self._renew()
            future = self._pool.schedule(function, args=arguments, timeout=self._patience)
        return _Job(function, arguments, self._pool, future)

    def end(self, job: _Job) -> Any:
        """The answer.

        Raises:
            _LostError: the process died of this job, or it hung.
        """
        try:
            return job.future.result(self._patience + _START_UP)
        except ProcessExpired as error:
            why = f"the engine's process died (exit code {error.exitcode})"
            raise _LostError(why) from error
        except TimeoutError as error:
            raise _LostError(f"the engine gave no answer for {self._patience:g} s") from error
        except BrokenProcessPool as error:
            # It died between two jobs, of neither.
            if job.repeated:
                raise _LostError("the engine's process died twice") from error
            # Its pool may not say so yet, and would break the job again.
            if job.pool is self._pool:
                self._renew()
            return self.end(replace(self.begin(job.function, job.arguments), repeated=True))

    def close(self) -> None:
        self._pool.stop()
        self._pool.join()

    def _renew(self) -> None:
        self.close()
        self._pool = self._new_pool()

    def _new_pool(self) -> ProcessPool:
        return ProcessPool(
            max_workers=1,
            context=multiprocessing.get_context("spawn"),
            initializer=_start,
            initargs=[self._make_model],
        )


def _result(worker: _Worker, job: _Job, state: SceneState) -> RolloutResult:
    try:
        return cast(RolloutResult, worker.end(job))
    except _LostError as error:
        return RolloutResult(state, (), (), frozenset(), False, 0.0, 0, lost=str(error))


_make_model: ModelFactory | None = None
_model: TransitionModel | None = None
"""Of a worker process; the model is made for its first job, so that errors reach who asked."""


def _start(make_model: ModelFactory) -> None:
    global _make_model
    _make_model = make_model


def _own_model() -> TransitionModel:
    global _model
    assert _make_model is not None, "the worker was not started by IsolatedModel"
    if _model is None:
        _model = _make_model()
    return _model


def _tool_pose(state: SceneState) -> Array:
    return _own_model().tool_pose(state)


def _rollout(
    state: SceneState,
    motion: Motion,
    parameters: ParameterOverrides | None,
    options: RolloutOptions | None,
    continue_from: Any,
) -> RolloutResult:
    model = _own_model()
    started = time.process_time()
    result = model.rollout(
        state, motion, parameters=parameters, options=options, continue_from=continue_from
    )
    return replace(result, outside_cpu=time.process_time() - started)
