"""What a user waits for: the help, and the first compilation."""

from __future__ import annotations

import os
import resource
import subprocess
import sysconfig
import tempfile
import time
from pathlib import Path

import numpy as np

from measures.common import Measured

REPEATS = 5


def measure_help() -> Measured:
    """Wall time of ``mamo --help`` in a new process."""
    runs = [_run("--help") for _ in range(REPEATS)]
    wall, cpu = np.median(runs, axis=0)
    how = f"median wall time of {REPEATS} new processes; CPU {cpu:.2f} s"
    return Measured({"help_s": float(wall)}, {"help_s": how})


def measure_compilation() -> Measured:
    """``mamo warmup`` with empty caches: robots are built and all kernels compiled."""
    with tempfile.TemporaryDirectory() as folder:
        fresh = {"NUMBA_CACHE_DIR": f"{folder}/numba", "MAMO_CACHE": f"{folder}/mamo"}
        wall, cpu = _run("warmup", **fresh)
    how = f"wall time of 'mamo warmup' with empty caches, robots included; CPU {cpu:.1f} s"
    return Measured({"compile_s": wall}, {"compile_s": how})


def _run(*arguments: str, **environment: str) -> tuple[float, float]:
    """Wall and CPU seconds of ``mamo`` with these arguments."""
    command = [str(Path(sysconfig.get_path("scripts")) / "mamo"), *arguments]
    started, used = time.perf_counter(), _children_cpu()
    subprocess.run(
        command, env={**os.environ, **environment}, stdout=subprocess.DEVNULL, check=True
    )
    return time.perf_counter() - started, _children_cpu() - used


def _children_cpu() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime
