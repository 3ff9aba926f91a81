"""Compiled loops of the vehicle over time; their rounding does not depend on how the steps are split into blocks."""

from __future__ import annotations

import numpy as np
from numba import njit

import dcrb_ros.core  # noqa: F401 - sets the folder of the compiled kernels
from dcrb_ros.schema.arrays import Complexes, Floats


@njit(cache=True, nogil=True, error_model="numpy")
def modal_outputs(
    growth: Complexes, before: Complexes, after: Complexes, read: Complexes, direct: Floats, state: Complexes, inputs: Floats
) -> Floats:
    """Return the outputs of a linear system in modal form at every tick, shape (ticks, outputs).

    Between two ticks the inputs, shape (ticks + 1, inputs), are straight lines. With the eigenvalues' factors ``growth``, shape (modes,),

        x[n+1] = growth x[n] + before u[n] + after u[n+1],   y[n] = Re(read x[n]) + direct u[n].

    ``state``, shape (modes,), is updated.
    """
    ticks, modes = inputs.shape[0] - 1, growth.shape[0]
    outputs = np.empty((ticks, read.shape[0]))
    for n in range(ticks):
        for o in range(read.shape[0]):
            total = 0.0
            for k in range(modes):
                total += read[o, k].real * state[k].real - read[o, k].imag * state[k].imag
            for i in range(inputs.shape[1]):
                total += direct[o, i] * inputs[n, i]
            outputs[n, o] = total
        for k in range(modes):
            x = growth[k] * state[k]
            for i in range(inputs.shape[1]):
                x += before[k, i] * inputs[n, i] + after[k, i] * inputs[n + 1, i]
            state[k] = x
    return outputs


@njit(cache=True, nogil=True, error_model="numpy")
def between_ticks(ticks: Floats, weights: Floats) -> Floats:
    """Return signals at the steps between their ticks, shape (signals, intervals * steps).

    ``weights``, shape (steps, taps), are those of ``taps`` ticks around each step of an interval; ``ticks``, shape
    (intervals + taps - 1, signals), begin taps/2 - 1 ticks before the first interval.
    """
    steps, taps = weights.shape
    intervals = ticks.shape[0] - taps + 1
    result = np.empty((ticks.shape[1], intervals * steps))
    for j in range(ticks.shape[1]):
        for n in range(intervals):
            for s in range(steps):
                total = 0.0
                for i in range(taps):
                    total += weights[s, i] * ticks[n + i, j]
                result[j, n * steps + s] = total
    return result


@njit(cache=True, nogil=True, error_model="numpy")
def add_path(sections: Floats, delays: Floats, memory: Floats, known: Floats, lead: int, target: Floats) -> None:
    """Add a source after the resonances of a path to ``target``, shape (steps,).

    Each of ``sections``, shape (resonances, 3), is a resonance gain (u[n] - u[n-2]) / (1 - a1 z^-1 - a2 z^-2) of the source some ``delays``
    ago [steps]. ``known`` is the source with its last ``lead`` samples before; ``memory``, shape (resonances, 2), is updated. Four
    resonances are computed at once to use the pipelines of the processor; they are added in their order.
    """
    whole = sections.shape[0] - sections.shape[0] % 4
    for k in range(0, whole, 4):
        ga, a1, a2 = sections[k]
        gb, b1, b2 = sections[k + 1]
        gc, c1, c2 = sections[k + 2]
        gd, d1, d2 = sections[k + 3]
        fa, sa = memory[k]
        fb, sb = memory[k + 1]
        fc, sc = memory[k + 2]
        fd, sd = memory[k + 3]
        a, b, c, d = lead - int(delays[k]), lead - int(delays[k + 1]), lead - int(delays[k + 2]), lead - int(delays[k + 3])
        for n in range(target.shape[0]):
            va = ga * (known[a + n] - known[a + n - 2]) + a1 * fa + a2 * sa
            vb = gb * (known[b + n] - known[b + n - 2]) + b1 * fb + b2 * sb
            vc = gc * (known[c + n] - known[c + n - 2]) + c1 * fc + c2 * sc
            vd = gd * (known[d + n] - known[d + n - 2]) + d1 * fd + d2 * sd
            sa, fa = fa, va
            sb, fb = fb, vb
            sc, fc = fc, vc
            sd, fd = fd, vd
            target[n] = target[n] + va + vb + vc + vd
        memory[k, 0], memory[k, 1] = fa, sa
        memory[k + 1, 0], memory[k + 1, 1] = fb, sb
        memory[k + 2, 0], memory[k + 2, 1] = fc, sc
        memory[k + 3, 0], memory[k + 3, 1] = fd, sd
    for k in range(whole, sections.shape[0]):
        gain, a1, a2 = sections[k]
        first, second = memory[k]
        start = lead - int(delays[k])
        for n in range(target.shape[0]):
            at = start + n
            value = gain * (known[at] - known[at - 2]) + a1 * first + a2 * second
            second = first
            first = value
            target[n] += value
        memory[k, 0] = first
        memory[k, 1] = second


@njit(cache=True, nogil=True, error_model="numpy")
def _cubic(values: Floats, position: float, offset: int) -> float:
    """Return the value of a grid at a position in its points beyond a whole offset, by the cubic of Keys (1981).

    It goes through the four nearest points. The offset lets a position have the same bits wherever ``values`` begins.
    """
    k = int(np.floor(position))
    t = position - k
    k += offset
    a, b, c, d = values[k - 1], values[k], values[k + 1], values[k + 2]
    value: float = b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
    return value


@njit(cache=True, nogil=True, error_model="numpy")
def cubic(values: Floats, position: Floats) -> Floats:
    """Return values of a grid at positions in its points, of which the second one is zero, shape (positions,)."""
    result = np.empty(position.shape[0])
    for n in range(position.shape[0]):
        result[n] = _cubic(values, position[n], 1)
    return result


@njit(cache=True, nogil=True, error_model="numpy")
def cubic_on_pages(values: Floats, first: int, points: int, length: float, grid: float, place: Floats) -> Floats:
    """Return values at places [m] of consecutive pages of a grid, shape (places,).

    Each page has so many ``points`` and a ``length`` [m]; ``values`` begin with the page number ``first``.
    """
    result = np.empty(place.shape[0])
    for n in range(place.shape[0]):
        page = np.floor(place[n] / length)
        result[n] = _cubic(values, (place[n] - page * length) / grid, (int(page) - first) * points)
    return result
