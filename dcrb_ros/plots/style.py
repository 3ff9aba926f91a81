"""Colours, axes and legends that the plots have in common."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dcrb_ros.schema.arguments import optional, with_attributes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

ABOVE_LEGEND = 22.0
"""Distance of a title from the axes that leaves the legend between them [points]."""

# The palette of Okabe and Ito, which people with colour blindness tell apart.
CURVE = "#404040"
AXES_COLOURS = {"x": "#E69F00", "y": "#0072B2"}
ROWS = ("#0072B2", "#D55E00")
FAULT_LINES = {"BPFO": "#D55E00", "BPFI": "#0072B2", "2BSF": "#009E73", "FTF": "#CC79A7"}
MARKERS = {"BPFO": "o", "BPFI": "s", "2BSF": "^", "FTF": "D"}
DASHES: dict[str, tuple[float, tuple[float, ...]]] = {
    "BPFO": (0.0, (4.0, 2.0)),
    "BPFI": (0.0, (6.0, 2.0, 1.0, 2.0)),
    "2BSF": (0.0, (1.0, 1.5)),
    "FTF": (0.0, (4.0, 1.5, 1.0, 1.5, 1.0, 1.5)),
}


MATPLOTLIB_AXES = optional(with_attributes("plot", "set_xlim", "get_figure", kind="axes of matplotlib"))
"""Check of the argument ``ax``."""


def new_axes(*, polar: bool = False, size: tuple[float, float] = (9.0, 3.2)) -> Axes:
    """Return the axes of a new figure, which notebooks show by themselves; its size in inches."""
    import matplotlib.pyplot as plt

    figure = plt.figure(figsize=size, layout="constrained")
    return figure.add_subplot(projection="polar" if polar else None)


MOST_CHARACTERS = 44
"""Characters that fit beside each other in a legend of four columns [-]."""


def legend_above(ax: Axes, handles: Sequence[Artist] | None = None) -> None:
    """Draw the legend above the axes, where it hides no curve; for the labelled curves, or for other handles."""
    shown = list(handles or ax.get_legend_handles_labels()[0])
    legend = ax.legend(
        handles=shown,
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        borderaxespad=0.2,
        ncols=_columns([str(handle.get_label()) for handle in shown]),
        columnspacing=1.4,
        handlelength=2.8,
        fontsize="small",
        frameon=False,
    )
    for text in legend.get_texts():
        text.set_parse_math(False)  # a dollar sign in a name is one


def _columns(labels: Sequence[str]) -> int:
    """Return the columns of a legend: four, or two where the labels would be wider than the axes."""
    return 4 if max(map(len, labels), default=0) * len(labels) <= MOST_CHARACTERS else 2


def _above(ax: Axes) -> float | None:
    """Return the distance of the title from the axes [pt], above the rows of a legend."""
    legend = ax.get_legend()
    if legend is None:
        return None
    labels = [text.get_text() for text in legend.get_texts()]
    return ABOVE_LEGEND * (-(-len(labels) // _columns(labels)))


def labelled(ax: Axes, x: str, y: str, title: str = "") -> Axes:
    """Return the axes with labels and a faint grid."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    if title:
        ax.set_title(title, fontsize="medium", loc="left", pad=_above(ax), parse_math=False)
    ax.grid(alpha=0.25, linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)
    return ax
