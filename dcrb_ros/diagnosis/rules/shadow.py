"""A parameter that the rules for inner ring and rollers share."""

from __future__ import annotations

from dcrb_ros.schema.fields import Group, quantity


class ShadowParameters(Group):
    """When BPFI or 2 BSF lines explain those of another component."""

    shadow: float = quantity(
        2.0,
        "-",
        "Ratio of modulation depths from which BPFI or 2 BSF lines explain lines of another component in the same band",
        0.1,
        100.0,
    )
