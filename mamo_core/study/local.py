"""Jobs side by side in worker processes of this machine."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from queue import Empty, SimpleQueue
from threading import Thread

from mamo_core.study.jobs import Job, Outcome
from mamo_core.study.worker import Worker


class LocalExecutor:
    """So many workers, which start with the first jobs and stay until it is closed."""

    def __init__(self, workers: int) -> None:
        self._workers = [Worker() for _ in range(workers)]

    def run(self, jobs: Sequence[Job]) -> Iterator[Outcome]:
        """One outcome for each job, in the order in which they end."""
        waiting: SimpleQueue[Job] = SimpleQueue()
        for job in jobs:
            waiting.put(job)
        done: SimpleQueue[Outcome | Exception] = SimpleQueue()
        for worker in self._workers[: len(jobs)]:
            # Daemons: an interrupted run does not wait for them.
            Thread(target=_work, args=(worker, waiting, done), daemon=True).start()
        for _ in jobs:
            outcome = done.get()
            if isinstance(outcome, Exception):
                raise outcome
            yield outcome

    def close(self) -> None:
        """End all workers, at work or not."""
        for worker in self._workers:
            worker.close()


def _work(
    worker: Worker, waiting: SimpleQueue[Job], done: SimpleQueue[Outcome | Exception]
) -> None:
    try:
        while True:
            done.put(worker.run(waiting.get_nowait()))
    except Empty:
        return
    except Exception as error:
        done.put(error)


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0))
