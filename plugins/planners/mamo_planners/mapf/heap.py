"""A binary heap of int64 keys in a plain array (kernels); the caller keeps the size."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mamo_planners.mapf.kernel import kernel

Int64Array = npt.NDArray[np.int64]


@kernel
def push_key(heap: Int64Array, size: int, key: int) -> int:
    """Adds ``key`` to the first ``size`` entries; returns the new size."""
    k = size
    while k > 0:
        parent = (k - 1) >> 1
        if heap[parent] <= key:
            break
        heap[k] = heap[parent]
        k = parent
    heap[k] = key
    return size + 1


@kernel
def pop_key(heap: Int64Array, size: int) -> tuple[int, int]:
    """Removes the least key of ``size`` entries; returns it and the new size."""
    least = heap[0]
    size -= 1
    key = heap[size]
    k = 0
    while True:
        child = 2 * k + 1
        if child >= size:
            break
        if child + 1 < size and heap[child + 1] < heap[child]:
            child += 1
        if heap[child] >= key:
            break
        heap[k] = heap[child]
        k = child
    heap[k] = key
    return least, size
