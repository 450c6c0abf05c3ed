"""What workers of the tests do: return, raise, die, hang, leave children behind.

``solve`` does what its seed says, so that a study file alone says what happens.
"""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from mamo_core.errors import PluginError

ABORT, SEGFAULT, HANG, FAIL, KILL, LEAVE, CHILD = range(100, 107)
SECONDS = ("cpu_s", "parts", "wall_s", "started", "finished")
"""Of a row: what may differ when the same is done again."""

LOG = "STUDY_DEEDS_LOG"
"""Environment: a file that gets a line for each thing done."""


def ready(**arguments: Any) -> None:
    note("ready")


def note(text: str) -> None:
    if LOG in os.environ:
        with Path(os.environ[LOG]).open("a") as file:
            file.write(f"{text}\n")


def solve(problem: dict[str, Any], recipe: dict[str, Any], seed: int, budget: float) -> Any:
    """A row that depends on nothing but the arguments; odd seeds fail."""
    deeds = {
        ABORT: abort,
        SEGFAULT: segfault,
        HANG: hang,
        FAIL: fail,
        KILL: kill,
        LEAVE: leave,
        CHILD: hang_with_child,
    }
    if seed in deeds:
        deeds[seed]()
    time.sleep(0.02)
    solved = seed % 2 == 0
    cpu = 0.01 * (seed + 1) * len(recipe["name"])
    note(f"solve {problem['name']} {recipe['name']} {seed}")
    return {
        "cpu_s": cpu,
        "parts": {"rollouts": 0.75 * cpu, "other": 0.25 * cpu},
        "status": "solved" if solved else "budget_exhausted",
        "verified": solved,
        "actions": seed,
        "counts": {"rollouts": 3 * seed},
        "causes": {} if solved else {"o1/push/no_ik": 2, "o2/push/no_ik": 1},
        "reason": "" if solved else "too hard",
        "plan": b"x" if solved else None,
    }


def classify(problem: dict[str, Any]) -> str:
    note(f"classify {problem['name']}")
    return "easy"


def generate(level: str, movables: int, seed: int) -> dict[str, Any]:
    from mamo_core.problems import generate_shelf, problem_document

    note(f"generate {level} {movables} {seed}")
    problem = generate_shelf(movables=movables, seed=seed)
    return {**problem_document(problem), "name": f"{level}_{movables}_{seed}"}


def generate_workspace(workspace: str, movables: int, immovables: int, seed: int) -> dict[str, Any]:
    from mamo_core import problems

    note(f"generate {workspace} {movables} {immovables} {seed}")
    problem = problems.generate_workspace(
        workspace, movables=movables, immovables=immovables, seed=seed
    )
    return problems.problem_document(problem)


def echo(value: Any = None) -> Any:
    return value


def pid() -> int:
    return os.getpid()


def fail(text: str = "no luck") -> None:
    raise TimeoutError(text)


def refuse() -> None:
    raise PluginError("there is no such engine")


def abort() -> None:
    os.abort()


def segfault() -> None:
    ctypes.string_at(0)


def leave(code: int = 3) -> None:
    os._exit(code)


def kill() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def hang() -> None:
    """In C, holding the interpreter's lock: no Python thread of the process runs any more."""
    while True:
        ctypes.PyDLL(None).sleep(600)


def hang_with_child() -> None:
    """Write down who we are and hang, with a child that hangs too."""
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    note(f"pids {os.getpid()} {child.pid}")
    hang()


def slow(seconds: float) -> None:
    time.sleep(seconds)


def environment(names: list[str]) -> dict[str, str | None]:
    return {name: os.environ.get(name) for name in names}
