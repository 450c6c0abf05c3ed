"""Many steps in one compiled stretch: it needs no interpreter between them, and no lock of it."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import llvmlite.binding
import mujoco
import numpy as np
from numba import njit, types

from mamo_core.constraints.kernels import largest_gap, within
from mamo_core.types.geometry import Array, IntArray
from mamo_core.types.rollout import Watch
from mamo_mujoco.kernels import at_rest, command, contact_pairs, observe
from mamo_mujoco.memory import CIntArray


def _load_library() -> None:
    """Let compiled code call the library of the bindings, which have it loaded already."""
    folder = Path(mujoco.__file__).parent
    library = next(p for p in folder.iterdir() if p.name.startswith(("libmujoco.", "mujoco.dll")))
    llvmlite.binding.load_library_permanently(str(library))


_load_library()
_mj_step = types.ExternalFunction("mj_step", types.void(types.intp, types.intp))


class Memory(NamedTuple):
    """Where model and data are, and views of what the loop writes and reads there."""

    model: int
    data: int
    ctrl: Array
    qpos: Array
    qvel: Array
    xpos: Array
    xmat: Array
    contact_count: CIntArray
    contact_geoms: CIntArray
    contact_distances: Array


class Places(NamedTuple):
    """Where things are in these arrays: as ``WorldIndex`` and ``observe`` have them."""

    arm_qpos: IntArray
    free_qvel: IntArray
    objects: IntArray
    entity: IntArray


@njit(nogil=True, cache=True)
def follow(
    memory: Memory,
    places: Places,
    watch: Watch,
    seen: Array,
    positions: Array,
    velocities: Array,
    drives: Array,
    lead: float,
) -> int:
    """``SimulatedWorld.follow`` with a watch; ``seen`` and ``lead`` as in the kernels."""
    for i in range(positions.shape[0]):
        command(memory.ctrl, positions[i], velocities[i], lead, drives[i])
        if not _harmless_step(memory, places, watch, seen, positions[i]):
            return i + 1
    return positions.shape[0]


@njit(nogil=True, cache=True)
def wait(
    memory: Memory,
    places: Places,
    watch: Watch,
    seen: Array,
    end: Array,
    steps: int,
    speed: float,
    spin: float,
) -> int:
    """``SimulatedWorld.wait`` with a watch."""
    for i in range(steps):
        if not _harmless_step(memory, places, watch, seen, end):
            return i + 1
        if at_rest(memory.qvel, places.free_qvel, speed, spin):
            return i + 1
    return steps


@njit(nogil=True, cache=True)
def _harmless_step(
    memory: Memory, places: Places, watch: Watch, seen: Array, reference: Array
) -> bool:
    """Simulate one step; False if somebody has to look at it."""
    _mj_step(memory.model, memory.data)
    geoms = memory.contact_geoms[: memory.contact_count[0]]
    pairs = np.empty((geoms.shape[0], 2), dtype=np.int64)
    contact_pairs(geoms, places.entity, pairs)
    for n in range(pairs.shape[0]):
        watch.touched[pairs[n, 0], pairs[n, 1]] = True
    observe(memory.xpos, memory.xmat, memory.qvel, places.objects, seen)
    depths = -memory.contact_distances[: memory.contact_count[0]]
    limits = (watch.bounds, watch.forbidden, watch.deepest, watch.gripped)
    if not within(seen[0], seen[1], seen[2], pairs, depths, *limits):
        return False
    return largest_gap(memory.qpos[places.arm_qpos], reference) <= watch.lag


def warm_up() -> None:
    """Compile the loops (or read them from numba's cache): no commands are no steps."""
    one, rows, flat = np.zeros(1, dtype=np.int64), np.zeros((1, 3)), np.zeros(1)
    geoms, pairs = np.zeros((2, 4), dtype=np.intc)[:, :2], np.zeros((1, 2), dtype=np.int64)
    count, distances = np.zeros(1, dtype=np.intc), np.zeros((2, 2))[:, 0]
    memory = Memory(0, 0, flat, flat, flat, rows, rows, count, geoms, distances)
    places = Places(one, one, pairs, one)
    table = np.zeros((1, 1), dtype=np.bool_)
    watch, seen = Watch(np.zeros((1, 6)), table, 0.0, -1, 0.0, table), np.zeros((3, 1, 3))
    follow(memory, places, watch, seen, rows[:0], rows[:0], flat[:0], 0.0)
    frozen = np.zeros(1)  # as trajectories are
    frozen.flags.writeable = False
    wait(memory, places, watch, seen, frozen, 0, 0.0, 0.0)
