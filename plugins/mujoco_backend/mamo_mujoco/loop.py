"""Many steps in one compiled stretch: it needs no interpreter between them, and no lock of it."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import llvmlite.binding
import mujoco
import numpy as np
from numba import njit, types

from mamo_core.constraints.kernels import largest_gap, within
from mamo_core.types.geometry import Array, BoolArray, IntArray
from mamo_mujoco.kernels import at_rest, command, contact_pairs, observe


def _load_library() -> None:
    """Let compiled code call the library that the bindings use (loaded once, under one name)."""
    folder = Path(mujoco.__file__).parent
    (library,) = (p for p in folder.iterdir() if p.name.startswith(("libmujoco.", "mujoco.dll")))
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
    contact_count: IntArray
    contact_geoms: IntArray


class Places(NamedTuple):
    """Where things are in these arrays: as ``WorldIndex`` and ``observe`` have them."""

    arm_qpos: IntArray
    free_qvel: IntArray
    objects: IntArray
    entity: IntArray


@njit(nogil=True, cache=True)
def run(
    memory: Memory,
    places: Places,
    positions: Array,
    velocities: Array,
    drives: Array,
    lead: float,
    bounds: Array,
    forbidden: BoolArray,
    lag: float,
    rest: tuple[float, float],
    touched: BoolArray,
    seen: Array,
) -> int:
    """``SimulatedWorld.advance`` with a watch; ``lead`` and ``seen`` as in the kernels."""
    for i in range(positions.shape[0]):
        command(memory.ctrl, positions[i], velocities[i], lead, drives[i])
        _mj_step(memory.model, memory.data)
        geoms = memory.contact_geoms[: memory.contact_count[0]]
        pairs = np.empty((geoms.shape[0], 2), dtype=np.int64)
        contact_pairs(geoms, places.entity, pairs)
        for n in range(pairs.shape[0]):
            touched[pairs[n, 0], pairs[n, 1]] = True
        observe(memory.xpos, memory.xmat, memory.qvel, places.objects, seen)
        harmless = within(seen[0], seen[1], seen[2], pairs, bounds, forbidden)
        gap = largest_gap(memory.qpos[places.arm_qpos], positions[i])
        if not harmless or gap > lag or at_rest(memory.qvel, places.free_qvel, rest[0], rest[1]):
            return i + 1
    return positions.shape[0]


def warm_up() -> None:
    """Compile the loop (or read it from numba's cache): no commands are no steps."""
    one, rows, flat = np.zeros(1, dtype=np.int64), np.zeros((1, 3)), np.zeros(1)
    geoms, pairs = np.zeros((2, 4), dtype=np.int32)[:, :2], np.zeros((1, 2), dtype=np.int64)
    allowed = np.zeros((1, 1), dtype=np.bool_)
    memory = Memory(0, 0, flat, flat, flat, rows, rows, np.zeros(1, dtype=np.int32), geoms)
    places = Places(one, one, pairs, one)
    none, bounds = np.zeros((0, 1)), np.zeros((1, 6))
    run(
        *(memory, places, none, none, none[:, 0].copy(), 0.0),
        *(bounds, allowed, 0.0, (0.0, 0.0), allowed.copy(), np.zeros((3, 1, 3))),
    )
