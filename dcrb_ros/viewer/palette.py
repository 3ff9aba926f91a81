"""Colours of the viewer for a dark background; every colour is sRGB with opacity, 0 to 255."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dcrb_ros.schema.arrays import Floats

Colour = tuple[int, int, int, int]
Colours = npt.NDArray[np.uint8]

BACKGROUND: Colour = (13, 13, 13, 255)
"""Background colour of Rerun's own panels."""
FAINT: Colour = (38, 45, 56, 255)
MUTED: Colour = (125, 137, 153, 255)
BRIGHT: Colour = (222, 229, 238, 255)
STEEL: Colour = (49, 58, 71, 255)
STEEL_EDGE: Colour = (104, 118, 137, 255)
BRASS: Colour = (150, 114, 52, 255)
UNLOADED: Colour = (92, 104, 121, 255)
DEFECT: Colour = (255, 64, 84, 255)
LOAD: Colour = (94, 196, 255, 255)
WAVEFORM: Colour = (94, 196, 255, 255)
WAVEFORM_X: Colour = (150, 128, 214, 255)
CURVE: Colour = (168, 182, 200, 255)
AREA: Colour = (44, 54, 70, 255)
FAULT_LINES: dict[str, Colour] = {
    "BPFO": (255, 170, 64, 255),
    "BPFI": (232, 110, 196, 255),
    "2BSF": (110, 214, 130, 255),
    "FTF": (120, 190, 255, 255),
}
ROWS: tuple[Colour, Colour] = ((255, 196, 87, 255), (94, 196, 255, 255))

# Nine equidistant points of the upper three quarters of matplotlib's "inferno", whose lightness grows evenly.
_INFERNO = np.array(
    [
        (87, 16, 110),
        (120, 28, 109),
        (153, 41, 100),
        (186, 54, 85),
        (214, 75, 63),
        (236, 105, 37),
        (249, 142, 9),
        (250, 186, 36),
        (246, 228, 99),
    ],
    np.float64,
)


def force_colours(force: Floats, largest: float) -> Colours:
    """Return the colour of normal forces [N] on a scale up to ``largest`` [N], shape (..., 4); grey without contact."""
    position = np.clip(np.asarray(force) / largest, 0.0, 1.0) * (len(_INFERNO) - 1)
    colours = np.empty((*position.shape, 4), np.uint8)
    for channel in range(3):
        colours[..., channel] = np.interp(position, np.arange(len(_INFERNO)), _INFERNO[:, channel])
    colours[..., 3] = 255
    colours[np.asarray(force) <= 0.0] = UNLOADED
    return colours


def wheel(count: int) -> list[Colour]:
    """Return ``count`` colours around the colour wheel with about equal lightness; neighbouring colours are similar."""
    angle = 2.0 * np.pi * np.arange(count) / count
    channels = [np.clip(165.0 + 80.0 * np.cos(angle - shift), 0, 255).astype(int) for shift in (0.0, 2.1, 4.2)]
    return [(int(red), int(green), int(blue), 255) for red, green, blue in zip(*channels, strict=True)]


def with_opacity(colour: Colour, opacity: float) -> Colour:
    """Return ``colour`` with an opacity of 0 to 1."""
    return (*colour[:3], round(255 * opacity))
