"""Jobs on a Ray cluster: in each actor the same worker process as on one machine.

A job that crashes or hangs costs its worker process, not the actor. An actor that is lost, with its
node for example, has lost its job through no fault of the job: another actor does it.
"""

from __future__ import annotations

import contextlib
import logging
import os
import tempfile
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from typing import Any

from mamo_core.errors import PluginError
from mamo_core.study.jobs import Failure, Job, Outcome
from mamo_core.study.worker import Worker

ADDRESS = "RAY_ADDRESS"
_LOST = object()
_LOST_ACTORS = 3
"""So many actors may be lost with the same job before it is taken for the cause."""


class RayExecutor:
    """So many actors, one CPU each, on the cluster at ``RAY_ADDRESS`` or one of our own."""

    def __init__(self, workers: int | None) -> None:
        self._ray = _connected()
        self._workers = workers if workers is not None else _cpus(self._ray)
        # Where a node is lost its actors are; a worker in them ends with them.
        self._actor = self._ray.remote(num_cpus=1, max_restarts=0)(_Actor)
        self._idle: list[Any] = []

    def run(self, jobs: Sequence[Job]) -> Iterator[Outcome]:
        """One outcome for each job, in the order in which they end."""
        waiting = deque(jobs)
        lost: Counter[str] = Counter()
        running = self._begin(min(self._workers, len(jobs)))
        left = len(jobs)
        while left:
            (done,), _ = self._ray.wait(list(running), num_returns=1)
            actor, job = running.pop(done)
            outcome = self._answer(done)
            if outcome is _LOST:
                actor = self._actor.remote()
                running[actor.is_there.remote()] = actor, None
                outcome = _after_loss(job, lost, waiting)
                actor = self._idle.pop() if waiting and self._idle else None
            if isinstance(outcome, Outcome):
                left -= 1
                yield outcome
            if actor is not None:
                self._next(actor, waiting, running)

    def close(self) -> None:
        """End all workers, at work or not."""
        for actor in self._idle:
            self._ray.kill(actor)
        self._ray.shutdown()

    def _answer(self, done: Any) -> Any:
        try:
            return self._ray.get(done)
        except self._ray.exceptions.RayActorError:
            return _LOST

    def _begin(self, count: int) -> dict[Any, tuple[Any, Job | None]]:
        """What is awaited first: that actors are there. Those without room are never heard of."""
        actors, self._idle = self._idle, []
        actors += [self._actor.remote() for _ in range(count - len(actors))]
        return {actor.is_there.remote(): (actor, None) for actor in actors}

    def _next(self, actor: Any, waiting: deque[Job], running: dict[Any, Any]) -> None:
        if waiting:
            job = waiting.popleft()
            running[actor.run.remote(job)] = actor, job
        else:
            self._idle.append(actor)


class _Actor:
    """Holds a worker process."""

    def __init__(self) -> None:
        self._worker = Worker()

    def is_there(self) -> None:
        """Answers as soon as the actor has a place."""

    def run(self, job: Job) -> Outcome:
        return self._worker.run(job)


def _after_loss(job: Job | None, lost: Counter[str], waiting: deque[Job]) -> Outcome | None:
    """Have the job done again, unless actors are lost with it again and again."""
    if job is None:
        return None
    lost[job.key] += 1
    if lost[job.key] < _LOST_ACTORS:
        waiting.appendleft(job)
        return None
    cause = f"{_LOST_ACTORS} Ray actors were lost while they did it"
    return Outcome(job.key, failure=Failure.CRASHED, cause=cause)


def _connected() -> Any:
    """Ray, connected to the cluster at ``RAY_ADDRESS``, or to a new one on this machine.

    Raises:
        PluginError: Ray is not installed, or there is no such cluster.
    """
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    try:
        import ray
    except ImportError as error:
        hint = "install it with: pip install 'mamo[cluster]'"
        raise PluginError(f"executor 'ray': {error}; {hint}") from error
    options: dict[str, Any] = {"log_to_driver": False, "logging_level": logging.ERROR}
    if ADDRESS in os.environ:
        options |= {"address": os.environ[ADDRESS]}
    else:
        options |= {"address": "local", "include_dashboard": False, "_temp_dir": _folder()}
    try:
        with contextlib.redirect_stdout(None):  # stdout is for results
            ray.init(**options)
    except (ConnectionError, OSError, RuntimeError, ValueError) as error:
        raise PluginError(f"executor 'ray': no cluster: {error}") from error
    return ray


def _folder() -> str:
    """A short path: Ray puts sockets there, whose paths may have about 100 characters."""
    return os.path.join(tempfile.gettempdir(), f"mamo_ray_{os.getuid()}")


def _cpus(ray: Any) -> int:
    return max(1, int(ray.cluster_resources().get("CPU", 1)))
