"""Derivation of the rational fit in `dcrb_ros.core.laws.johnson`. Needs mpmath.

The fit approximates -W_-1(-e^l) for l = -40 .. -4 by P(t)/Q(t) with t = (l + 22)/18, by linearised least squares of the relative error
at Chebyshev nodes; in each iteration the equations are weighted by the previous denominator.
"""

from __future__ import annotations

import mpmath

LOW, HIGH = mpmath.mpf(-40), mpmath.mpf(-4)
ABOVE, BELOW = 8, 7
"""Degrees of the numerator and the denominator."""
NODES = 6 * (ABOVE + BELOW + 1)
TURNS = 12


def wanted(log_ratio: mpmath.mpf) -> mpmath.mpf:
    """Return -W_-1(-e^l)."""
    return -mpmath.lambertw(-mpmath.exp(log_ratio), -1).real


def scaled(log_ratio: mpmath.mpf) -> mpmath.mpf:
    """Return t, scaled to -1 .. 1."""
    return (2 * log_ratio - LOW - HIGH) / (HIGH - LOW)


def fit() -> tuple[list[mpmath.mpf], list[mpmath.mpf]]:
    """Return the coefficients of numerator and denominator, from the constant up."""
    nodes = [(LOW + HIGH + (HIGH - LOW) * mpmath.cos(mpmath.pi * (2 * k + 1) / (2 * NODES))) / 2 for k in range(NODES)]
    values, ts, weights = [wanted(node) for node in nodes], [scaled(node) for node in nodes], [mpmath.mpf(1)] * NODES
    above, below = [mpmath.mpf(0)], [mpmath.mpf(1)]
    for _ in range(TURNS):
        rows = [
            [*(weight * t**j / value for j in range(ABOVE + 1)), *(-weight * t**j for j in range(1, BELOW + 1))]
            for t, value, weight in zip(ts, values, weights, strict=True)
        ]
        coefficients = list(mpmath.qr_solve(mpmath.matrix(rows), mpmath.matrix(weights))[0])
        above, below = coefficients[: ABOVE + 1], [mpmath.mpf(1), *coefficients[ABOVE + 1 :]]
        weights = [1 / abs(mpmath.polyval(below[::-1], t)) for t in ts]
    return above, below


def main() -> None:
    """Print the coefficients and the largest relative error."""
    mpmath.mp.dps = 50
    above, below = fit()
    points = [LOW + (HIGH - LOW) * k / 999 for k in range(1000)]
    errors = [abs(mpmath.polyval(above[::-1], scaled(x)) / mpmath.polyval(below[::-1], scaled(x)) / wanted(x) - 1) for x in points]
    print("numerator  ", *(mpmath.nstr(value, 20) for value in above))
    print("denominator", *(mpmath.nstr(value, 20) for value in below))
    print("largest relative error", mpmath.nstr(max(errors), 3))


if __name__ == "__main__":
    main()
