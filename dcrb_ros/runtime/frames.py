"""pandas, where it is installed."""

from __future__ import annotations

from types import ModuleType

from dcrb_ros.runtime.optional import installed


def pandas() -> ModuleType:
    """Return the module pandas, imported by the first call.

    Raises:
        Refusal: it is not installed.
    """
    return installed("pandas", "to_pandas needs pandas, which is not installed: pip install pandas")
