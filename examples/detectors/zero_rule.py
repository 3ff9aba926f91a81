"""The zero rule: every bearing is healthy. Whatever scores no better has learnt nothing."""

VARIANTS = {
    "zero rule": {},
}
"""Settings of each member of the family; the first has the published ones."""


class ZeroRule:
    """Report ``healthy`` for every block."""

    def __init__(self, orders, rate):
        pass

    def update(self, index, acceleration, shaft_angle):
        """Return the verdict on a block."""
        return "healthy"
