"""What an explanation holds."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Obstruction(StrEnum):
    """What kind of thing stands in the way, the most fundamental first.

    RETRIEVAL: the target cannot be taken out even without movables. PATHS: objects cannot get out
    of its way even without physics. ACTION: no action moves an object out of the way. EXECUTION:
    nothing is in the way, but the retrieval or the plan fails when it is executed. UNKNOWN: what
    failed most often is all that is known, if anything failed.
    """

    RETRIEVAL = "retrieval"
    PATHS = "paths"
    ACTION = "action"
    EXECUTION = "execution"
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class Detail:
    """Something that failed ``times`` times, under its key ``subject/action/cause``.

    ``words``: the cause for people. ``involved``: others that took part, as pairs (name, times),
    the most frequent first.
    """

    subject: str
    action: str
    cause: str
    times: int
    words: str
    involved: tuple[tuple[str, int], ...] = ()

    @property
    def others(self) -> tuple[str, ...]:
        """Names of those involved."""
        return tuple(name for name, _ in self.involved)


@dataclass(frozen=True)
class Explanation:
    """``headline``: one sentence. ``subjects``, ``causes`` and ``involved``: what it is about.

    ``details``: everything that was counted, the most frequent first.
    """

    headline: str
    obstruction: Obstruction
    subjects: tuple[str, ...]
    causes: tuple[str, ...]
    involved: tuple[str, ...]
    details: tuple[Detail, ...]
