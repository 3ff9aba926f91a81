"""What the site takes from the code when it is built."""

from __future__ import annotations

from typing import Any

from dcrb_ros.configuration_file import parameter_table

PARAMETERS = "<!-- parameter table -->"


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Put the parameter table in the place kept for it."""
    return markdown.replace(PARAMETERS, parameter_table()) if PARAMETERS in markdown else markdown
