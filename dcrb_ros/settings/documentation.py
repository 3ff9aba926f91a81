"""The parameters as Markdown, for the documentation and `dcrb config docs`."""

from __future__ import annotations

import itertools
import re

from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.parameter_field import ParameterField
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import parameter_fields
from dcrb_ros.settings.parameters import COMMANDED

UNIT_SIGNS = (("^2", "²"), ("sqrt(Hz)", "√Hz"), ("ug/", "µg/"))
"""Units as the schema writes them, and as the documentation does."""


def parameter_table(model: type[Group] = Configuration) -> str:
    """Return the parameters as Markdown: a table per group, with name, range and unit in one column, default and meaning."""
    lines: list[str] = []
    for group, fields in itertools.groupby(parameter_fields(model), lambda field: field.key.partition(".")[0] if "." in field.key else ""):
        if group or lines:
            lines += ["", f"### {group or 'no group'}", ""]
        lines += ["| parameter, range, unit | default | meaning |", "|---|---|---|"]
        lines += [_row(field) for field in fields]
    return "\n".join(lines).strip()


def _row(field: ParameterField) -> str:
    """Return a parameter as a row of its table."""
    default = f"{field.default:.6g}" if isinstance(field.default, float) else str(field.default)
    return f"| `{field.key}`{_range(field)} | {default} | {field.description}{_symbol(field)}{_changeable(field)} |"


def _range(field: ParameterField) -> str:
    """Return the range and the unit of a parameter, or its choices, on a line of their own."""
    if field.choices:
        return f"<br>{', '.join(field.choices)}"
    if field.low is None or field.high is None:
        return ""
    unit = field.unit if field.unit != "-" else ""
    for plain, sign in UNIT_SIGNS:
        unit = unit.replace(plain, sign)
    return f"<br>{' to '.join(field.limits)} {unit}".rstrip()


def _symbol(field: ParameterField) -> str:
    """Return the symbol of a parameter as a formula; a Greek letter is spelt out in the schema."""
    return f", ${re.sub('^([a-z]{2,})', lambda name: chr(92) + name[1], field.symbol)}$" if field.symbol else ""


def _changeable(field: ParameterField) -> str:
    """Return a remark on a parameter that can change at run time."""
    return "" if not field.run_time else ". *Changes by command.*" if field.key in COMMANDED else ". *Changes at run time.*"
