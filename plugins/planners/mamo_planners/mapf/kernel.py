"""How every kernel of this package is compiled."""

from __future__ import annotations

from numba import njit

kernel = njit(cache=True, error_model="numpy", fastmath=False)
"""Compiled once and kept on disk; no check for division by zero (it hinders the optimiser)."""
