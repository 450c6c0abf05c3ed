"""A worker process that may crash or hang: that costs its job and nothing else.

The process is the only one of its pool and leads a process group of its own, so that whatever it
has started ends with it. A guard outside ends the group, too, when we end, however we end.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import subprocess
import time
from collections.abc import Callable
from concurrent.futures import TimeoutError
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import Any

from pebble import ProcessExpired, ProcessPool

from mamo_core.errors import MamoError, WorkerCrashedError
from mamo_core.study.jobs import Call, Failure, Job, Outcome

START_UP = 300.0
"""Wall time (s) that getting ready may take: imports, kernels, a first problem."""

_GRACE = 30.0
_IDLE_DEATHS = 3
_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
_GUARD = 'exec 3<&0; { read -r _ <&3; kill -s KILL -- "-$1"; } &'


class LostError(Exception):
    """Why there is no answer."""

    def __init__(self, failure: Failure, cause: str) -> None:
        super().__init__(cause)
        self.failure = failure


@dataclass(frozen=True)
class _Answer:
    """A value, or in words what was raised; ``refused``: that itself, if a user can mend it."""

    value: Any = None
    error: str = ""
    refused: MamoError | None = None


class Worker:
    """Runs one job at a time; its process stays alive and is replaced when it dies."""

    def __init__(self) -> None:
        self._process: _Process | None = None
        self._closed = False

    def run(self, job: Job) -> Outcome:
        """What became of the job; never raises because of it."""
        for _ in range(_IDLE_DEATHS):
            try:
                return self._run(job)
            except BrokenProcessPool:  # it died between two jobs, of neither
                self._end_process()
        cause = "the worker died again and again before it began"
        return Outcome(job.key, failure=Failure.CRASHED, cause=cause)

    def close(self) -> None:
        """End the process, at work or not."""
        self._closed = True
        self._end_process()

    def _run(self, job: Job) -> Outcome:
        started, stage = time.time(), "getting ready: "
        try:
            process = self._started()
            answer = process.make_ready(job.ready)
            if not answer.error:
                started, stage = time.time(), ""
                answer = process.call(job.work, job.deadline)
            failure = Failure.ERROR if answer.error else None
        except LostError as lost:
            self._end_process()
            answer, failure = _Answer(error=str(lost)), lost.failure
        return Outcome(
            job.key,
            answer.value,
            failure,
            stage + answer.error if answer.error else "",
            answer.refused if stage else None,
            started,
            time.time() - started,
        )

    def _started(self) -> _Process:
        if self._closed:
            raise LostError(Failure.CRASHED, "the worker was closed")
        if self._process is None:
            self._process = _Process()
        return self._process

    def _end_process(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.end()


class _Process:
    """A process and its guard."""

    def __init__(self) -> None:
        self._pool = ProcessPool(
            max_workers=1, context=multiprocessing.get_context("spawn"), initializer=_begin
        )
        self._ready: list[Call] = []
        self._guard: subprocess.Popen[bytes] | None = None
        try:
            self._group = self._answer(os.getpid, (), START_UP)
        except LostError as error:
            self.end()
            raise WorkerCrashedError(f"worker processes cannot start: {error}") from error
        self._guard = _guard(self._group)

    def make_ready(self, ready: Call | None) -> _Answer:
        """Call ``ready`` unless that has been done."""
        if ready is None or ready in self._ready:
            return _Answer()
        answer = self.call(ready, START_UP)
        if not answer.error:
            self._ready.append(ready)
        return answer

    def call(self, call: Call, limit: float) -> _Answer:
        """What the call returned, or raised.

        Raises:
            LostError: the process died of it, or did not answer within ``limit`` seconds.
        """
        answer: _Answer = self._answer(_perform, (call,), limit)
        return answer

    def end(self) -> None:
        if self._guard is not None:
            with contextlib.suppress(OSError):  # there is nobody left
                os.killpg(self._group, signal.SIGKILL)
            self._guard.communicate()  # its pipe closes
        self._pool.stop()
        self._pool.join()

    def _answer(
        self, function: Callable[..., Any], arguments: tuple[Any, ...], limit: float
    ) -> Any:
        try:
            future = self._pool.schedule(function, args=arguments, timeout=limit)
        except RuntimeError as error:
            raise BrokenProcessPool(str(error)) from error
        try:
            return future.result(limit + _GRACE + START_UP)
        except ProcessExpired as error:
            raise LostError(Failure.CRASHED, _ending(error.exitcode)) from error
        except TimeoutError as error:
            raise LostError(Failure.TIMEOUT, f"no answer for {limit:g} s") from error


def _ending(code: int) -> str:
    if code >= 0:
        return f"the worker ended with exit code {code}"
    try:
        return f"the worker was ended by {signal.Signals(-code).name}"
    except ValueError:
        return f"the worker was ended by signal {-code}"


def _guard(group: int) -> subprocess.Popen[bytes]:
    """Reads from a pipe that closes when this process ends, then ends the group.

    A process of its own, since a worker that hangs in C cannot look after itself; and not a child
    of ours, since Ray kills those of an actor without asking what they are for.
    """
    return subprocess.Popen(
        ["/bin/sh", "-c", _GUARD, "sh", str(group)],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def _begin() -> None:
    """In the worker, before anything heavy is imported."""
    os.setsid()
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))


def _perform(call: Call) -> _Answer:
    """In the worker; an exception is an answer, so that none is taken for one of the pool's."""
    try:
        return _Answer(call())
    except Exception as error:
        words = f"{type(error).__name__}: {error}"
        return _Answer(error=words, refused=error if isinstance(error, MamoError) else None)
