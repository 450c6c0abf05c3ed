"""Jobs for worker processes, and what became of them."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Protocol

from mamo_core.errors import MamoError


@dataclass(frozen=True)
class Call:
    """A function by its name, ``module:function``, and its keyword arguments: plain data."""

    function: str
    arguments: Mapping[str, Any] = field(default_factory=dict)

    def __call__(self) -> Any:
        module, _, name = self.function.partition(":")
        function: Callable[..., Any] = getattr(importlib.import_module(module), name)
        return function(**self.arguments)


@dataclass(frozen=True)
class Job:
    """A call that has ``deadline`` seconds of wall time, counted from when the worker is ready.

    ``ready``: what a worker calls once before its first job with the same ``ready``.
    """

    key: str
    work: Call
    deadline: float
    ready: Call | None = None


class Failure(StrEnum):
    """How a job ended without a value."""

    CRASHED = "crashed"
    TIMEOUT = "timeout"
    ERROR = "error"


@dataclass(frozen=True)
class Outcome:
    """The value of a job, or how it failed and the ``cause`` in words.

    ``refused``: what getting ready complained about; no such job can ever run.
    ``started``: seconds since the epoch. ``wall``: seconds.
    """

    key: str
    value: Any = None
    failure: Failure | None = None
    cause: str = ""
    refused: MamoError | None = None
    started: float = field(default_factory=time.time)
    wall: float = 0.0


class Executor(Protocol):
    """Runs jobs in worker processes."""

    def run(self, jobs: Sequence[Job]) -> Iterator[Outcome]:
        """One outcome for each job, in the order in which they end."""
        ...

    def close(self) -> None:
        """End all workers, at work or not."""
        ...
