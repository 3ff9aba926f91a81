"""pandas, where it is installed."""

from __future__ import annotations

from types import ModuleType

from dcrb_ros.schema.refusal import Refusal


def pandas() -> ModuleType:
    """Return the module pandas, imported by the first call.

    Raises:
        Refusal: it is not installed.
    """
    try:
        import pandas as pd
    except ImportError:
        raise Refusal("to_pandas needs pandas, which is not installed: pip install pandas") from None
    module: ModuleType = pd
    return module
