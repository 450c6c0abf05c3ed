"""An engine that dies takes one rollout with it, nothing else."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time

from mamo_core.testing.conformance.bench import Bench, require
from mamo_core.testing.conformance.scenery import still
from mamo_core.testing.transition_cases import standard_constraints


def killed(bench: Bench) -> str:
    cases = bench.cases
    problem = cases.problem
    model = bench.make_default(problem, bench.arm, standard_constraints(problem))
    start = problem.initial
    model.rollout(start, cases.still)
    workers = [p for p in multiprocessing.active_children() if p.pid is not None]
    require(workers, "no engine process is running")
    assassin = threading.Thread(target=_kill_soon, args=[workers])
    assassin.start()
    result = model.rollout(start, still(600.0, start.joint_positions))
    assassin.join()
    require(result.lost, "the engine was killed, and the result does not say so")
    require(not result.valid, "a lost rollout counts as valid")
    after = model.rollout(start, cases.still)
    require(after.lost is None, f"the next rollout is lost, too: {after.lost}")
    return str(result.lost)


def _kill_soon(workers: list[multiprocessing.Process]) -> None:
    time.sleep(0.5)
    for worker in workers:
        if worker.pid is not None and worker.is_alive():
            os.kill(worker.pid, signal.SIGKILL)
