"""The processor for which the kernels are compiled, as far as the samples depend on it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

FUSED = "fma"
"""The feature that changes most samples: a fused multiply-add rounds once where a product and a sum round twice."""
RECORDED = (FUSED, "avx", "avx2", "avx512f")
"""Features that a manifest records. The wider vectors change no sample: each lane rounds like a single number."""


def processor() -> dict[str, Any]:
    """Return the processor for which numba compiles, and those of the `RECORDED` features that it has."""
    import numba
    from numba.core.registry import cpu_target

    if getattr(numba.config, "DISABLE_JIT"):  # noqa: B009 - untyped
        return {"target": "none, the kernels are not compiled", "features": []}
    _, name, features = cpu_target.target_context.codegen().magic_tuple()
    present = set(str(features).split(","))
    return {"target": str(name), "features": [feature for feature in RECORDED if f"+{feature}" in present]}


def described(about: Mapping[str, Any]) -> str:
    """Return a processor in words."""
    return f"{about.get('target', 'unknown')} ({', '.join(_features(about)) or 'none of ' + ', '.join(RECORDED)})"


def processor_difference(recorded: Mapping[str, Any] | None, present: Mapping[str, Any]) -> str:
    """Return how the kernels of a recording differ from the present ones in fused multiply-adds; the empty string if they do not.

    Of a sum of two products the compiler fuses one, which it chooses by the processor that it compiles for.
    A recording without this entry was made before manifests had it, most likely on a processor with fused multiply-add.
    """
    fuses = FUSED in _features(present)
    if recorded is None:
        return "" if fuses else f"its processor is not recorded, and this one, {described(present)}, has no fused multiply-add"
    if (FUSED in _features(recorded)) == fuses:
        if not fuses or recorded.get("target") == present.get("target"):
            return ""
        return (
            f"its kernels were compiled for {described(recorded)}, and the present ones for {described(present)}, for which the compiler "
            "may fuse other products"
        )
    have, lack = ("without", "with") if fuses else ("with", "without")
    return (
        f"its kernels were compiled {have} fused multiply-add, for {described(recorded)}, and the present ones {lack} it, for "
        f"{described(present)}"
    )


def _features(about: Mapping[str, Any]) -> list[str]:
    features = about.get("features")
    return [str(feature) for feature in features] if isinstance(features, list) else []
