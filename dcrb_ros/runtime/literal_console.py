"""A console that prints text from outside literally: neither rich nor the terminal takes it for markup or control characters."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.text import Text

from dcrb_ros.schema.printable import printable_lines


class LiteralConsole(Console):
    """Prints every string, also those in the cells of a table, as it is; control characters are escaped. Styles need a `Text`."""

    def __init__(self, **options: Any) -> None:
        super().__init__(markup=False, emoji=False, highlight=False, **options)

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a string as text to print."""
        return super().render_str(printable_lines(text), **options)
