"""The cyclic coherence of a window: the modulation spectrum of each carrier frequency, which two families share."""

import numpy as np
from trending import over_angle

RESOLUTION = 400.0
"""Width of a carrier band [Hz], at least a 64th of the sampling rate."""


def cyclic_coherence(acceleration, angle, rate):
    """Return |gamma|^2 of shape (carriers, orders), and the revolutions of the window [-].

    gamma(f, alpha) = F_t |X(f, t)|^2 / mean_t |X(f, t)|^2, with X the short-time Fourier transform by Hann windows, an eighth apart. The
    division whitens the carriers. This is a normalised cyclic modulation spectrum (Antoni, Xin and Hamzaoui 2017); it
    contains modulation up to the width of a carrier band. The power of each carrier is averaged over equal steps of the shaft angle.
    """
    width = max(int(rate / max(RESOLUTION, rate / 64.0)), 16)
    frames = np.lib.stride_tricks.sliding_window_view(acceleration, width)[:: max(width // 8, 1)]
    power = np.abs(np.fft.rfft(frames * np.hanning(width), axis=1)[:, 1:-1]) ** 2
    rows = []
    for carrier in (power / np.maximum(power.mean(axis=0), 1e-300)).T:
        even, turns = over_angle(carrier, angle)
        rows.append(np.abs(np.fft.rfft((even - even.mean()) * np.hanning(len(even)))) ** 2 / len(even) ** 2)
    return np.array(rows), turns
