"""The axes of a sensor."""

AXES = ("ax", "ay", "az")
"""Names of the accelerations of a sensor with two or three axes; one axis serves as two."""
