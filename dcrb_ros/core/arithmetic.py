"""Logarithm and exponential in plain arithmetic: the compiler works on several rollers at once, which no library call allows.

Both are right to a few units in the last place, and the same on every processor with fused multiply-add.
"""

from __future__ import annotations

import struct
from typing import Any

import numba
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from dcrb_ros.core.jit import kernel

LOG_2 = 0.6931471805599453
LOG2_E = 1.4426950408889634
LOG_2_HIGH, LOG_2_LOW = 0.693147180369123816490, 1.90821492927058770002e-10
"""ln 2 in two parts, the first with room for a product with an exponent."""
ROOT_HALF = 0x3FE6A09E667F3BCD
"""The bits of the square root of one half."""
LEAST_EXPONENT = -700.0
PI, HALF_PI = 3.141592653589793, 1.5707963267948966
LEAST_PENETRATION = 1e-15
"""Penetration that an open contact is evaluated at [m], so that a law needs no branch."""
INTEGERS, INTEGER_BITS = 6755399441055744.0, 0x4338000000000000
"""1.5 * 2^52, whose last bits are an integer: conversions that every vector unit can do."""

if getattr(numba.config, "DISABLE_JIT"):  # noqa: B009 - numba's configuration is untyped

    def bits_of(x: float) -> int:
        """Return the bits of a float as an integer."""
        return int(struct.unpack("<q", struct.pack("<d", x))[0])

    def float_of(bits: int) -> float:
        """Return the float of some bits."""
        return float(struct.unpack("<d", struct.pack("<q", bits))[0])

    def single_of(bits: int) -> float:
        """Return the number in single precision of the lower half of some bits."""
        return float(struct.unpack("<f", struct.pack("<I", int(bits) & 0xFFFFFFFF))[0])

else:

    @intrinsic
    def bits_of(typingctx: Any, x: Any) -> Any:
        """Return the bits of a float as an integer."""

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.bitcast(arguments[0], ir.IntType(64))

        return types.int64(types.float64), codegen

    @intrinsic
    def float_of(typingctx: Any, bits: Any) -> Any:
        """Return the float of some bits."""

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.bitcast(arguments[0], ir.DoubleType())

        return types.float64(types.int64), codegen

    @intrinsic
    def single_of(typingctx: Any, bits: Any) -> Any:
        """Return the number in single precision of the lower half of some bits."""

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            half = builder.trunc(arguments[0], ir.IntType(32))
            return builder.fpext(builder.bitcast(half, ir.FloatType()), ir.DoubleType())

        return types.float64(types.int64), codegen


@kernel
def logarithm(x: float) -> float:
    """Return the natural logarithm of a normal number above zero."""
    bits = bits_of(x)
    exponent = (bits - ROOT_HALF) >> 52
    mantissa = float_of(bits - (exponent << 52))
    s = (mantissa - 1.0) / (mantissa + 1.0)
    z = s * s
    # By halves, so that the terms do not wait for each other.
    z2 = z * z
    z4 = z2 * z2
    low = (2.0 / 3.0 + z * (2.0 / 5.0)) + z2 * (2.0 / 7.0 + z * (2.0 / 9.0))
    high = (2.0 / 11.0 + z * (2.0 / 13.0)) + z2 * (2.0 / 15.0 + z * (2.0 / 17.0)) + z4 * (2.0 / 19.0)
    series = low + z4 * high
    return s * (2.0 + z * series) + (float_of(exponent + INTEGER_BITS) - INTEGERS) * LOG_2


@kernel
def exponential(x: float) -> float:
    """Return e to the power of a number that is not above 700; 0 below -700."""
    held = max(x, LEAST_EXPONENT)
    shifted = held * LOG2_E + INTEGERS
    whole = shifted - INTEGERS
    rest = held - whole * LOG_2_HIGH - whole * LOG_2_LOW
    r2 = rest * rest
    r4 = r2 * r2
    low = (1.0 + rest) + r2 * (0.5 + rest * (1.0 / 6.0))
    middle = (1.0 / 24.0 + rest * (1.0 / 120.0)) + r2 * (1.0 / 720.0 + rest * (1.0 / 5040.0))
    high = (1.0 / 40320.0 + rest * (1.0 / 362880.0)) + r2 * (1.0 / 3628800.0 + rest * (1.0 / 39916800.0))
    series = low + r4 * (middle + r4 * high)
    power = series * float_of((bits_of(shifted) - INTEGER_BITS + 1023) << 52)
    return power if x > LEAST_EXPONENT else 0.0


@kernel
def angle_of(across: float, along: float) -> float:
    """Return the angle of a vector that is not zero, as ``atan2(across, along)`` within 2e-12 [rad]."""
    far, near = max(abs(across), abs(along)), min(abs(across), abs(along))
    ratio = near / far
    u = ratio * ratio
    u2 = u * u
    u4 = u2 * u2
    low = (0.9999999999984469 - 0.3333333327068445 * u) + u2 * (0.19999995789128855 - 0.14285602071866202 * u)
    middle = (0.11109537094684067 - 0.09077527397029952 * u) + u2 * (0.0761738834386099 - 0.0637516111282671 * u)
    high = (0.050635121489975524 - 0.03551192121238829 * u) + u2 * (0.02016180214869038 - 0.008374940837300619 * u)
    highest = 0.002208757735567428 - 0.0002736296793322768 * u
    angle = ratio * (low + u4 * (middle + u4 * (high + u4 * highest)))
    angle = HALF_PI - angle if abs(across) > abs(along) else angle
    angle = PI - angle if along < 0.0 else angle
    return angle if across >= 0.0 else -angle
