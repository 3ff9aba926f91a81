"""The console that prints text from outside literally."""

from __future__ import annotations

import io

from rich.table import Table

from dcrb_ros.runtime.literal_console import LiteralConsole


def test_strings_and_cells_are_printed_as_they_are() -> None:
    output = io.StringIO()
    console = LiteralConsole(file=output, width=80)
    console.print("[/bold] :smile: [m/s²]\nsecond line \x1b[2J\u202e")
    table = Table("level [dB]", "[red]topic", title="[link=x]\x07")
    table.add_row("[/]", "\x9b2J")
    console.print(table)
    shown = output.getvalue()
    for words in ("[/bold] :smile: [m/s²]\nsecond line \\x1b[2J\\u202e", "level [dB]", "[red]topic", "[link=x]\\x07", "[/]", "\\x9b2J"):
        assert words in shown
    assert not {"\x1b", "\x07", "\x9b", "\u202e"} & set(shown)
