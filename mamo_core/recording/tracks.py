"""Executions of one plan in several engines, put on one time grid.

Engines need different times until objects rest. Times are therefore counted from the start of each
segment, and an engine that is done with a segment earlier waits for the others.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mamo_core.types.geometry import Array, BoolArray, IntArray
from mamo_core.types.rollout import RolloutResult, Trace

_EPSILON = 1e-9


@dataclass(frozen=True, eq=False)
class Tracks:
    """What every engine did on the common grid.

    ``times`` (t,) s; ``segments`` (t,) number of the segment; by engine ``poses`` (t, n, 7),
    ``joints`` (t, dof), ``openings`` (t,) and ``contacts`` (t, e, e). The grid ends where the first
    engine stopped.
    """

    times: Array
    segments: IntArray
    poses: Mapping[str, Array]
    joints: Mapping[str, Array]
    openings: Mapping[str, Array]
    contacts: Mapping[str, BoolArray]


def align(rollouts: Mapping[str, RolloutResult]) -> Tracks:
    """Put recorded rollouts of the same motion on one grid.

    Raises:
        ValueError: a rollout has no trace, or one without contacts.
    """
    traces = {name: _trace(name, result) for name, result in rollouts.items()}
    cuts = {name: _cuts(traces[name], result) for name, result in rollouts.items()}
    count = min(len(starts) for starts in cuts.values())
    rows: dict[str, list[IntArray]] = {name: [] for name in rollouts}
    segments: list[IntArray] = []
    for number in range(count):
        longest = max(len(starts[number]) for starts in cuts.values())
        segments.append(np.full(longest, number))
        for name, starts in cuts.items():
            own = starts[number]
            rows[name].append(np.concatenate([own, np.repeat(own[-1:], longest - len(own))]))
    picked = {name: np.concatenate(parts) for name, parts in rows.items()}
    number_of = np.concatenate(segments)
    step = _step(next(iter(traces.values())))
    return Tracks(
        times=np.arange(len(number_of), dtype=np.float64) * step,
        segments=number_of,
        poses={name: traces[name].poses[index] for name, index in picked.items()},
        joints={name: traces[name].joints[index] for name, index in picked.items()},
        openings={name: traces[name].openings[index] for name, index in picked.items()},
        contacts={name: _contacts(traces[name])[index] for name, index in picked.items()},
    )


def _trace(name: str, result: RolloutResult) -> Trace:
    trace = result.trace
    if trace is None or trace.contacts is None:
        raise ValueError(f"engine {name!r} has recorded no trace with contacts")
    return trace


def _contacts(trace: Trace) -> BoolArray:
    assert trace.contacts is not None
    return trace.contacts


def _cuts(trace: Trace, result: RolloutResult) -> list[IntArray]:
    """The rows of the trace that belong to each segment; each has one row at least."""
    final = len(trace.times) - 1
    starts = np.array(result.segment_times)
    ends = np.array([*result.segment_times[1:], result.duration])
    firsts = np.minimum(np.searchsorted(trace.times, starts - _EPSILON), final)
    lasts = np.minimum(np.searchsorted(trace.times, ends - _EPSILON), final + 1)
    return [
        np.arange(first, max(last, first + 1)) for first, last in zip(firsts, lasts, strict=True)
    ]


def _step(trace: Trace) -> float:
    return float(trace.times[1] - trace.times[0]) if len(trace.times) > 1 else 0.0
