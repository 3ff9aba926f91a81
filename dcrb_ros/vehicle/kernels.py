"""Compiled loops of the vehicle over time; their rounding does not depend on how the steps are split into blocks."""

from __future__ import annotations

import numpy as np
from numba import njit

import dcrb_ros.core  # noqa: F401 - sets the folder of the compiled kernels
from dcrb_ros.schema.arrays import Complexes, Floats, Integers


@njit(cache=True, nogil=True, error_model="numpy")
def modal_outputs(
    growth: Complexes, before: Complexes, after: Complexes, read: Complexes, direct: Floats, state: Complexes, inputs: Floats
) -> Floats:
    """Return the outputs of a linear system in modal form at every tick, shape (ticks, outputs).

    Between two ticks the inputs, shape (ticks + 1, inputs), are straight lines. With the eigenvalues' factors ``growth``, shape (modes,),

        x[n+1] = growth x[n] + before u[n] + after u[n+1],   y[n] = Re(read x[n]) + direct u[n].

    ``state``, shape (modes,), is updated.
    """
    ticks, modes, count = inputs.shape[0] - 1, growth.shape[0], read.shape[0]
    # Every sum keeps its order. What is innermost, modes or four outputs, is independent and in real numbers, and uses the pipelines.
    read_real, read_imag, through = read.real.T.copy(), read.imag.T.copy(), direct.T.copy()
    grow_real, grow_imag, real, imag = growth.real.copy(), growth.imag.copy(), state.real.copy(), state.imag.copy()
    before_real, before_imag, after_real, after_imag = before.real.T.copy(), before.imag.T.copy(), after.real.T.copy(), after.imag.T.copy()
    outputs = np.zeros((ticks, count))
    for n in range(ticks):
        for o in range(0, count - count % 4, 4):
            a = b = c = d = 0.0
            for k in range(modes):
                a += read_real[k, o] * real[k] - read_imag[k, o] * imag[k]
                b += read_real[k, o + 1] * real[k] - read_imag[k, o + 1] * imag[k]
                c += read_real[k, o + 2] * real[k] - read_imag[k, o + 2] * imag[k]
                d += read_real[k, o + 3] * real[k] - read_imag[k, o + 3] * imag[k]
            outputs[n, o], outputs[n, o + 1], outputs[n, o + 2], outputs[n, o + 3] = a, b, c, d
        for o in range(count - count % 4, count):
            for k in range(modes):
                outputs[n, o] += read_real[k, o] * real[k] - read_imag[k, o] * imag[k]
        for i in range(inputs.shape[1]):
            for o in range(count):
                outputs[n, o] += through[i, o] * inputs[n, i]
        for k in range(modes):
            turned = grow_real[k] * imag[k] + grow_imag[k] * real[k]
            real[k] = grow_real[k] * real[k] - grow_imag[k] * imag[k]
            imag[k] = turned
        for i in range(inputs.shape[1]):
            now, then = inputs[n, i], inputs[n + 1, i]
            for k in range(modes):
                real[k] += before_real[i, k] * now + after_real[i, k] * then
                imag[k] += before_imag[i, k] * now + after_imag[i, k] * then
    for k in range(modes):
        state[k] = complex(real[k], imag[k])
    return outputs


@njit(cache=True, nogil=True, error_model="numpy")
def add_motion_of_others(
    growth: Complexes,
    before: Complexes,
    after: Complexes,
    read: Complexes,
    direct: Floats,
    states: Complexes,
    inputs: Floats,
    last: Floats,
    target: Floats,
) -> None:
    """Add what a linear system makes of the inputs of all other boxes, on straight lines between ticks, to ``target``, (boxes, steps).

    ``before``, ``after`` and ``direct`` have shape (boxes, ..., 1), and ``inputs`` (boxes, ticks + 1, 1); see `modal_outputs`. The outputs
    at the tick before the first one, ``last``, shape (boxes, boxes), and ``states``, shape (boxes, modes), are updated.
    """
    steps = target.shape[1] // (inputs.shape[1] - 1)
    for source in range(inputs.shape[0]):
        outputs = modal_outputs(growth, before[source], after[source], read, direct[source], states[source], inputs[source])
        for box in range(target.shape[0]):
            for n in range(outputs.shape[0] if box != source else 0):
                first = outputs[n - 1, box] if n > 0 else last[source, box]
                rise = outputs[n, box] - first
                for s in range(steps):
                    target[box, n * steps + s] += rise * (s / steps) + first
        last[source] = outputs[-1]


@njit(cache=True, nogil=True, error_model="numpy")
def along_lines(ticks: Floats, steps: int) -> Floats:
    """Return signals, shape (signals, ticks), on straight lines between their ticks, shape (signals, (ticks - 1) * steps)."""
    result = np.empty((ticks.shape[0], (ticks.shape[1] - 1) * steps))
    for j in range(ticks.shape[0]):
        for n in range(ticks.shape[1] - 1):
            rise = ticks[j, n + 1] - ticks[j, n]
            for s in range(steps):
                result[j, n * steps + s] = rise * (s / steps) + ticks[j, n]
    return result


@njit(cache=True, nogil=True, error_model="numpy")
def ramped(first: float, target: float, most: float, ticks: int) -> Floats:
    """Return a value that moves to a ``target`` by ``most`` at most in each tick, shape (ticks + 1,)."""
    result = np.empty(ticks + 1)
    result[0] = first
    for n in range(ticks):
        result[n + 1] = result[n] + max(-most, min(most, target - result[n]))
    return result


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
    ago [steps]. ``known`` is the source with its last ``lead`` samples before; ``memory``, shape (resonances, 2), is updated. The
    number of resonances is a multiple of four. Four are computed at once to use the pipelines of the processor, and added in their order.
    """
    for k in range(0, sections.shape[0], 4):
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


@njit(cache=True, nogil=True, error_model="numpy")
def add_paths(ends: Integers, sections: Floats, delays: Floats, memory: Floats, known: Floats, lead: int, target: Floats) -> None:
    """Add sources after the resonances of all paths to ``target``, shape (boxes, columns, steps), path by path.

    ``ends``, shape (paths, 2), are the source and the box of each; ``sections``, ``delays`` and ``memory``, shape (paths, columns,
    resonances, 2), are as in `add_path`; ``known``, shape (sources, columns, lead + steps), are the sources.
    """
    for p in range(ends.shape[0]):
        for column in range(known.shape[1]):
            add_path(sections[p], delays[p], memory[p, column], known[ends[p, 0], column], lead, target[ends[p, 1], column])


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
