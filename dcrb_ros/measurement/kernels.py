"""Compiled loops over samples. They call no other kernel, and their rounding does not depend on how the samples are split."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

import dcrb_ros.core  # noqa: F401 - sets the folder of the compiled kernels
from dcrb_ros.schema.arrays import Complexes, Floats, Integers


@njit(cache=True, nogil=True, error_model="numpy")
def filtered(sections: Floats, memory: Floats, samples: Floats) -> Floats:
    """Return ``samples``, shape (samples, columns), through second-order sections, shape (sections, 6), in transposed direct form II.

    ``memory``, shape (sections, 2, columns), is the state of the sections and is updated.
    """
    filtered: Floats = samples.copy()
    for i in range(filtered.shape[0]):
        for column in range(filtered.shape[1]):
            x = filtered[i, column]
            for k in range(sections.shape[0]):
                y = sections[k, 0] * x + memory[k, 0, column]
                memory[k, 0, column] = sections[k, 1] * x - sections[k, 4] * y + memory[k, 1, column]
                memory[k, 1, column] = sections[k, 2] * x - sections[k, 5] * y
                x = y
            filtered[i, column] = x
    return filtered


@njit(cache=True, nogil=True, error_model="numpy")
def decimated(taps: Floats, known: Floats, first: int, factor: int, count: int) -> Floats:
    """Return ``count`` sums of ``taps`` times samples, the first at sample ``first``, the others ``factor`` apart, shape (count, 2).

    Each sum adds its products in the order of time. The samples are sorted by their place between two sums, so that the processor computes
    sums side by side.
    """
    length = len(taps)
    places = np.zeros((2, factor, count + (length - 1) // factor))
    for k in range(places.shape[2]):
        for place in range(min(factor, len(known) - first - k * factor)):
            places[0, place, k], places[1, place, k] = known[first + k * factor + place, 0], known[first + k * factor + place, 1]
    sums = np.zeros((2, count))
    for axis in range(2):
        total = sums[axis]
        for tap in range(length):
            weight, values = taps[tap], places[axis, tap % factor, tap // factor : tap // factor + count]
            for k in range(count):
                total[k] += values[k] * weight
    due: Floats = sums.T.copy()
    return due


@njit(cache=True, nogil=True, error_model="numpy")
def interpolated(known: Floats, at: Integers, position: Floats, weights: Floats, out: Floats) -> None:
    """Interpolate the first two columns of ``known``, shape (samples, columns), at ``place`` (0 to 1) after the samples ``at``.

    ``weights``, shape (phases + 1, taps), belong to the samples on both sides; they are interpolated linearly between two phases.
    The result goes to ``out``, shape (len(at), 2).
    """
    phases, taps = weights.shape[0] - 1, weights.shape[1]
    for i in range(len(at)):
        row = min(int(position[i] * phases), phases - 1)
        share = position[i] * phases - row
        first = at[i] + 1 - taps // 2
        x = y = 0.0
        for tap in range(taps):
            weight = weights[row, tap] + share * (weights[row + 1, tap] - weights[row, tap])
            x += weight * known[first + tap, 0]
            y += weight * known[first + tap, 1]
        out[i, 0], out[i, 1] = x, y


@njit(cache=True, nogil=True, error_model="numpy")
def near_sums(taps: Floats, known: Floats, before: int) -> Floats:
    """Return the sums of ``taps``, shape (axes, taps), times the samples up to each one, shape (axes, samples - before).

    ``known`` has shape (axes, samples) and begins so many samples ``before`` the first sum. Each sum adds its products from the newest
    sample back; parts of 512 sums stay in the cache of the processor.
    """
    axes, length = taps.shape
    count = known.shape[1] - before
    sums = np.zeros((axes, count))
    for axis in range(axes):
        for first in range(0, count, 512):
            part = sums[axis, first : min(first + 512, count)]
            size = part.shape[0]
            for tap in range(0, length - length % 4, 4):
                a, b, c, d = taps[axis, tap], taps[axis, tap + 1], taps[axis, tap + 2], taps[axis, tap + 3]
                newest = before + first - tap
                now, one = known[axis, newest : newest + size], known[axis, newest - 1 : newest - 1 + size]
                two, three = known[axis, newest - 2 : newest - 2 + size], known[axis, newest - 3 : newest - 3 + size]
                for i in range(size):
                    part[i] = part[i] + a * now[i] + b * one[i] + c * two[i] + d * three[i]
            for tap in range(length - length % 4, length):
                for i in range(size):
                    part[i] += taps[axis, tap] * known[axis, before + first - tap + i]
    return sums


@njit(cache=True, nogil=True, error_model="numpy")
def product_sums(responses: Floats, inputs: Floats, newest: int) -> Floats:
    """Return the sum of complex ``responses`` times ``inputs``, shape (axes, 2, bins).

    Both have shape (frames, axes, 2, bins), real and imaginary parts, and an even number of frames. ``inputs`` is a ring: the newest frame
    is multiplied by the first response, the one before it by the second, and so on.
    """
    frames, axes, _, bins = responses.shape
    sums = np.zeros((axes, 2, bins))
    for axis in range(axes):
        real, imaginary = sums[axis, 0], sums[axis, 1]
        for k in range(0, frames, 2):
            first, second = (newest - k + frames) % frames, (newest - k - 1 + frames) % frames
            a, b, c, d = responses[k, axis, 0], responses[k, axis, 1], inputs[first, axis, 0], inputs[first, axis, 1]
            p, q, r, s = responses[k + 1, axis, 0], responses[k + 1, axis, 1], inputs[second, axis, 0], inputs[second, axis, 1]
            for i in range(bins):
                real[i] = real[i] + (a[i] * c[i] - b[i] * d[i]) + (p[i] * r[i] - q[i] * s[i])
                imaginary[i] = imaginary[i] + (a[i] * d[i] + b[i] * c[i]) + (p[i] * s[i] + q[i] * r[i])
    return sums


@njit(cache=True, nogil=True, error_model="numpy")
def later_spectra(responses: Floats, ring: Floats, newest: int, spectra: Complexes) -> Complexes:
    """Return the spectra of what frames and those before them add to the frame after each, shape (axes, frames, bins).

    ``spectra`` are those of the frames, same shape. They are put into the ``ring`` of `product_sums` behind the ``newest``.
    """
    later = np.empty_like(spectra)
    for f in range(spectra.shape[1]):
        place = (newest + 1 + f) % ring.shape[0]
        ring[place, :, 0], ring[place, :, 1] = spectra[:, f].real, spectra[:, f].imag
        sums = product_sums(responses, ring, place)
        later[:, f] = sums[:, 0] + 1j * sums[:, 1]
    return later


@njit(cache=True, nogil=True, error_model="numpy")
def add_modes(tangent: Floats, loss: Floats, participation: Floats, response: Floats) -> None:
    """Add the impulse responses of participation s^2 / (s^2 + loss w s + w^2) to ``response``, shape (axes, samples).

    ``tangent`` is tan(pi f / rate) of each mode, and ``participation`` has shape (axes, modes). A mode ends once it has decayed to 1e-14.
    """
    axes, samples = response.shape
    for mode in range(len(tangent)):
        t, damping = tangent[mode], loss[mode] * tangent[mode]
        scale = 1.0 / (1.0 + damping + t * t)
        p, q = 2.0 * (1.0 - t * t) * scale, (damping - 1.0 - t * t) * scale
        duration = min(samples, 2 + int(-64.5 / math.log(-q)))
        before = last = 0.0
        for i in range(duration):
            force = scale if i == 0 or i == 2 else (-2.0 * scale if i == 1 else 0.0)
            present = force + p * last + q * before
            before, last = last, present
            for axis in range(axes):
                response[axis, i] += participation[axis, mode] * present
