"""What the site takes from the code when it is built."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from dcrb_ros.settings.files import parameter_table

EXAMPLE = re.compile("<!-- example: (.*) -->")
EXAMPLES = Path(__file__).parents[1] / "examples"
PARAMETERS = "<!-- parameter table -->"


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Put the parameter table and the examples in the places kept for them."""
    markdown = EXAMPLE.sub(lambda found: f"```python\n{(EXAMPLES / found[1]).read_text()}```", markdown)
    return markdown.replace(PARAMETERS, parameter_table()) if PARAMETERS in markdown else markdown
