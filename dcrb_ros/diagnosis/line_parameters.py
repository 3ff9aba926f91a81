"""Parameters that all rules for lines share."""

from __future__ import annotations

from dcrb_ros.schema.fields import Group, quantity


class LineParameters(Group):
    """When lines are significant, and when they are the image of others."""

    false_alarm: float = quantity(
        1e-4,
        "-",
        "Probability per window and fault with which noise may have lines as strong as those that indicate the fault",
        1e-12,
        0.1,
    )
    shadow: float = quantity(
        0.5,
        "-",
        "Modulation depth relative to that of another fault below which lines are taken for an image of it, as the sidebands of one fault "
        "can lie on the lines of another",
        0.0,
        1.0,
    )
    ring_contrast: float = quantity(
        1.5,
        "dB",
        "Largest amplitude of the lines of a ring required over that of FTF and its double, where cage modulation has its "
        "largest lines",
        0.0,
        20.0,
    )
    learn_margin: float = quantity(4.0, "dB", "Margin of learned limits over the largest lines of the healthy bearing", 0.0, 40.0)
