"""Compiled time parametrisation: a speed profile along a polyline, smoothed over time.

The profile is the fastest whose speed builds up and falls no faster than the accelerations allow
and is low enough at every corner. Its even samples, averaged over a few (a box filter, as in
Biagiotti and Melchiorri, FIR filters for online trajectory planning with time- and frequency-domain
specifications, Control Engineering Practice 20, 2012), are the control points of a uniform cubic
B-spline. Differences of control points bound its derivatives, so that limits can be read off, and a
cubic between rows that are ``step`` apart is the spline itself.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mamo_core.types.geometry import Array, BoolArray

_PIECE = 0.1
"""Longest stretch (s at full speed) within which nothing but the speed changes."""
_ROUNDS = 8
_EASED = 0.98
"""Share of what is asked for when a place is slowed down."""
_STRAIGHT = 1e-9


@njit(cache=True, error_model="numpy")
def smooth_rows(
    points: Array,
    durations: Array,
    acceleration: Array,
    jerk: Array,
    ramp: float,
    step: float,
    taps: int,
    blend: float,
) -> tuple[float, Array, Array]:
    """Rows of the trajectory along ``points`` (k, dof): their distance (s), positions, velocities.

    ``durations`` (k - 1,): seconds from each point to the next at full speed, above 0, which it
    takes ``ramp`` s to build up. ``acceleration``, ``jerk`` (dof,): limits. ``step`` (s): about the
    distance of rows; ``taps``: samples averaged. ``blend``: how far (rad) no joint is from the
    polyline at a corner that has no others beside it.
    """
    counts = np.maximum(np.ceil(durations / _PIECE), 1.0).astype(np.int64)
    nodes, lengths = _divided(points, durations, counts)
    rates = _rates(points, durations, counts)
    window = taps * step
    caps, bends = _corners(rates, acceleration * window, blend * 8.0 / window)
    gains = _gains(rates, acceleration, ramp)
    speeds, times = _profile(lengths, caps, gains)
    control, h = _control(nodes, rates, lengths, speeds, times, gains, step, taps)
    for _ in range(_ROUNDS):
        if not _slower(control, h, taps, acceleration, jerk, times, speeds, bends, caps, gains):
            break
        speeds, times = _profile(lengths, caps, gains)
        control, h = _control(nodes, rates, lengths, speeds, times, gains, step, taps)
    h *= _stretch(control, h, acceleration, jerk)
    positions, velocities = _hermite(control, h)
    positions[0] = points[0]
    positions[-1] = points[-1]
    return h, positions, velocities


@njit(cache=True, error_model="numpy")
def _divided(points: Array, durations: Array, counts: Array) -> tuple[Array, Array]:
    """Where each piece begins (m, dof), and how long it takes at full speed (m,)."""
    total = counts.sum()
    nodes, lengths = np.empty((total, points.shape[1])), np.empty(total)
    n = 0
    for i in range(counts.shape[0]):
        for k in range(counts[i]):
            share = k / counts[i]
            lengths[n] = durations[i] / counts[i]
            for j in range(points.shape[1]):
                nodes[n, j] = points[i, j] + share * (points[i + 1, j] - points[i, j])
            n += 1
    return nodes, lengths


@njit(cache=True, error_model="numpy")
def _rates(points: Array, durations: Array, counts: Array) -> Array:
    """Velocities (m, dof) of each piece at full speed."""
    rates = np.empty((counts.sum(), points.shape[1]))
    n = 0
    for i in range(counts.shape[0]):
        for _ in range(counts[i]):
            for j in range(points.shape[1]):
                rates[n, j] = (points[i + 1, j] - points[i, j]) / durations[i]
            n += 1
    return rates


@njit(cache=True, error_model="numpy")
def _corners(rates: Array, jumps: Array, blend: float) -> tuple[Array, BoolArray]:
    """Highest share of full speed (m + 1,) at the ends of pieces, and where the path bends.

    No joint's speed jumps by more than ``jumps`` (dof,), nor by more than ``blend`` rad/s.
    """
    count = rates.shape[0]
    caps, bends = np.ones(count + 1), np.zeros(count + 1, dtype=np.bool_)
    caps[0] = caps[count] = 0.0
    for n in range(1, count):
        for j in range(rates.shape[1]):
            jump = abs(rates[n, j] - rates[n - 1, j])
            if jump > _STRAIGHT:
                bends[n] = True
                caps[n] = min(caps[n], min(jumps[j], blend) / jump)
    return caps, bends


@njit(cache=True, error_model="numpy")
def _gains(rates: Array, acceleration: Array, ramp: float) -> Array:
    """How fast the share of full speed may change on each piece (m,), 1/s."""
    gains = np.full(rates.shape[0], 1.0 / ramp)
    for n in range(rates.shape[0]):
        for j in range(rates.shape[1]):
            if abs(rates[n, j]) * gains[n] > acceleration[j]:
                gains[n] = acceleration[j] / abs(rates[n, j])
    return gains


@njit(cache=True, error_model="numpy")
def _profile(lengths: Array, caps: Array, gains: Array) -> tuple[Array, Array]:
    """Shares of full speed and times (m + 1,) at the ends of pieces."""
    count = lengths.shape[0]
    speeds, times = caps.copy(), np.zeros(count + 1)
    for n in range(count):
        fastest = np.sqrt(speeds[n] ** 2 + 2.0 * gains[n] * lengths[n])
        speeds[n + 1] = min(speeds[n + 1], fastest)
    for back in range(count):
        n = count - 1 - back
        fastest = np.sqrt(speeds[n + 1] ** 2 + 2.0 * gains[n] * lengths[n])
        speeds[n] = min(speeds[n], fastest)
    for n in range(count):
        peak = _peak(speeds[n], speeds[n + 1], gains[n], lengths[n])
        rising, falling = (peak - speeds[n]) / gains[n], (peak - speeds[n + 1]) / gains[n]
        ramps = rising * (peak + speeds[n]) + falling * (peak + speeds[n + 1])
        even = max(lengths[n] - 0.5 * ramps, 0.0) / peak
        times[n + 1] = times[n] + rising + even + falling
    return speeds, times


@njit(cache=True, error_model="numpy")
def _peak(first: float, last: float, gain: float, length: float) -> float:
    """Highest share of full speed on a piece."""
    return min(1.0, np.sqrt(0.5 * (first * first + last * last) + gain * length))


@njit(cache=True, error_model="numpy")
def _control(
    nodes: Array,
    rates: Array,
    lengths: Array,
    speeds: Array,
    times: Array,
    gains: Array,
    step: float,
    taps: int,
) -> tuple[Array, float]:
    """Control points (c, dof), the first and the last three alike, and the time between them."""
    count, dof = rates.shape
    steps = max(1, int(np.ceil(times[count] / step - 1e-9)))
    h = float(times[count] / steps)
    sampled = np.empty((steps + 1, dof))
    n = 0
    for i in range(steps + 1):
        time = i * h
        while n < count - 1 and time >= times[n + 1]:
            n += 1
        gone = (
            lengths[n] if i == steps else _gone(n, time - times[n], speeds, times, gains, lengths)
        )
        for j in range(dof):
            sampled[i, j] = nodes[n, j] + gone * rates[n, j]
    control = np.empty((steps + taps + 4, dof))
    for i in range(control.shape[0]):
        for j in range(dof):
            total = 0.0
            for k in range(taps):
                total += sampled[min(max(i - 2 - k, 0), steps), j]
            control[i, j] = total / taps
    return control, h


@njit(cache=True, error_model="numpy")
def _gone(n: int, time: float, speeds: Array, times: Array, gains: Array, lengths: Array) -> float:
    """How much of piece ``n`` (s at full speed) is behind after ``time`` s on it."""
    first, last, gain = speeds[n], speeds[n + 1], gains[n]
    peak = _peak(first, last, gain, lengths[n])
    rising, falling = (peak - first) / gain, (peak - last) / gain
    left = times[n + 1] - times[n] - time
    if time < rising:
        gone = time * (first + 0.5 * gain * time)
    elif left < falling:
        gone = lengths[n] - left * (last + 0.5 * gain * left)
    else:
        gone = 0.5 * rising * (first + peak) + (time - rising) * peak
    return min(max(gone, 0.0), lengths[n])


@njit(cache=True, error_model="numpy")
def _shares(
    control: Array, i: int, h: float, acceleration: Array, jerk: Array
) -> tuple[float, float]:
    """Largest share of a joint's acceleration and of its jerk at control points from ``i`` on."""
    of_acceleration, of_jerk = 0.0, 0.0
    for j in range(control.shape[1]):
        second = control[i, j] - 2.0 * control[i + 1, j] + control[i + 2, j]
        of_acceleration = max(of_acceleration, abs(second) / (h * h * acceleration[j]))
        if i + 3 < control.shape[0]:
            after = control[i + 1, j] - 2.0 * control[i + 2, j] + control[i + 3, j]
            of_jerk = max(of_jerk, abs(after - second) / (h * h * h * jerk[j]))
    return of_acceleration, of_jerk


@njit(cache=True, error_model="numpy")
def _slower(
    control: Array,
    h: float,
    taps: int,
    acceleration: Array,
    jerk: Array,
    times: Array,
    speeds: Array,
    bends: BoolArray,
    caps: Array,
    gains: Array,
) -> bool:
    """Lower ``caps`` and ``gains`` around where a limit is exceeded; whether that is anywhere."""
    count = gains.shape[0]
    worst = np.ones(count + 1)
    first = 0
    for i in range(control.shape[0] - 2):
        of_acceleration, of_jerk = _shares(control, i, h, acceleration, jerk)
        share = max(of_acceleration, of_jerk)
        if share <= 1.0:
            continue
        # What these control points come from.
        begin, end = (i - 2 - taps) * h, (i + 2) * h
        while first < count - 1 and times[first + 1] < begin:
            first += 1
        for n in range(first, count + 1):
            if n > first and times[n - 1] > end:
                break
            worst[n] = max(worst[n], share)
    found = False
    for n in range(count + 1):
        if worst[n] <= 1.0:
            continue
        found = True
        if bends[n]:
            caps[n] = min(caps[n], speeds[n]) * _EASED / np.sqrt(worst[n])
        if n < count:
            gains[n] *= _EASED / worst[n]
    return found


@njit(cache=True, error_model="numpy")
def _stretch(control: Array, h: float, acceleration: Array, jerk: Array) -> float:
    """By how much the time between control points must grow so that all limits are kept."""
    factor = 1.0
    for i in range(control.shape[0] - 2):
        of_acceleration, of_jerk = _shares(control, i, h, acceleration, jerk)
        factor = max(factor, np.sqrt(of_acceleration), np.cbrt(of_jerk))
    return factor


@njit(cache=True, error_model="numpy")
def _hermite(control: Array, h: float) -> tuple[Array, Array]:
    """Positions and velocities (c - 2, dof) of the spline at its knots."""
    rows = control.shape[0] - 2
    positions = np.empty((rows, control.shape[1]))
    velocities = np.empty((rows, control.shape[1]))
    for i in range(rows):
        for j in range(control.shape[1]):
            a, b, c = control[i, j], control[i + 1, j], control[i + 2, j]
            positions[i, j] = (a + 4.0 * b + c) / 6.0
            velocities[i, j] = (c - a) / (2.0 * h)
    return positions, velocities


def warm_up() -> None:
    """Compile the kernels (or read them from numba's cache)."""
    points = np.array([[0.0], [1.0]])
    smooth_rows(points, np.ones(1), np.ones(1), np.ones(1), 0.2, 0.02, 3, 0.002)
