"""Reference pages that are generated from the code, and names and pictures that fit a narrow screen, when the site is built."""

from __future__ import annotations

import html
import inspect
import re
from collections.abc import Iterator
from typing import Any

import typer
from mkdocs.exceptions import PluginError

from dcrb_ros.cli.app import app
from dcrb_ros.cli.vehicle_parameters import vehicle_parameters
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.exam.replica_priors import prior_table
from dcrb_ros.messages.topics import table_of, topic_table
from dcrb_ros.messages.topics.vehicle import VEHICLE
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.documentation import parameter_table

BLOCK_OR_CODE = re.compile("<pre.*?</pre>|<code>[^<]*</code>", re.DOTALL)
PICTURE = re.compile(r'<img alt="[^"]*" src="([^":]+)" />')
EXAMPLE = re.compile(r": (dcrb .+?)(\.?)$", re.MULTILINE)
FIGURE = "data:image/png;base64"
WARNINGS = re.compile('<div[^>]*data-mime-type="application/vnd.jupyter.stderr"')


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Replace the markers of a page by what is generated for them."""
    generated = {
        "parameters": lambda: parameter_table(Configuration),
        "detector parameters": lambda: parameter_table(DetectorParameters),
        "vehicle parameters": lambda: parameter_table(vehicle_parameters()),
        "vehicle detector parameters": lambda: parameter_table(VehicleDetectorParameters),
        "topics": topic_table,
        "vehicle topics": lambda: table_of(VEHICLE),
        "priors": prior_table,
        "commands": command_reference,
    }
    for name, generate in generated.items():
        marker = f"<!-- {name} -->"
        if marker in markdown:
            markdown = markdown.replace(marker, generate())
    return markdown


def on_page_content(content: str, **_: Any) -> str:
    """Let long names break after a dot, an underscore or a slash, but options nowhere, and link every picture to its file."""

    def broken(code: re.Match[str]) -> str:
        if code[0].startswith("<pre"):
            return code[0]
        named = re.sub(r"(?<=\w)([._/])(?=\w)", r"\1<wbr>", code[0])
        return re.sub(r"(?<![\w-])--?[A-Za-z][a-z-]*", r'<span class="option">\g<0></span>', named)

    return PICTURE.sub(r'<a href="\1">\g<0></a>', BLOCK_OR_CODE.sub(broken, content))


def on_post_page(output: str, page: Any, config: Any) -> str:
    """Refuse an executed notebook that shows no figure or prints warnings; one that fails has already ended the build."""
    if page.file.src_uri.endswith(".ipynb") and config.plugins["mkdocs-jupyter"].config["execute"]:
        if FIGURE not in output:
            raise PluginError(f"{page.file.src_uri} shows no figure")
        if WARNINGS.search(output):
            raise PluginError(f"{page.file.src_uri} prints warnings: run it and remove their causes")
    return output


def command_reference() -> str:
    """Return the commands of `dcrb` as Markdown: usage, description, and a table of arguments and options."""
    return "\n".join(_described(typer.main.get_command(app), "dcrb"))


def _described(command: Any, name: str) -> Iterator[str]:
    """Yield the description of a command and of those below it."""
    if below := getattr(command, "commands", {}):
        for part, subcommand in below.items():
            yield from _described(subcommand, f"{name} {part}")
        return
    parameters = [parameter for parameter in command.params if parameter.name != "help"]
    names = {p: [p.metavar or p.name.upper()] if p.param_type_name == "argument" else p.opts for p in parameters}
    usage = [name]
    usage += [names[p][0] if p.required else f"[{names[p][0]}]" for p in parameters if p.param_type_name == "argument"]
    usage += ["[OPTIONS]"] if any(p.param_type_name == "option" for p in parameters) else []
    text = EXAMPLE.sub(r": `\1`\2", "\n\n".join(filter(None, (inspect.cleandoc(command.help or ""), command.epilog))))
    yield from (f"## {name}", "", text, "", f"```sh\n{' '.join(usage)}\n```", "")
    if parameters:
        yield from ("| argument or option | default | meaning |", "|---|---|---|")
    for parameter in parameters:
        label = ", ".join(f'<code class="option">{html.escape(part)}</code>' for part in names[parameter])
        default = "required" if parameter.required else _shown(parameter.default)
        meaning = html.escape(parameter.help or "")
        yield "| " + " | ".join(cell.replace("|", "&#124;") for cell in (label, default, meaning)) + " |"
    yield ""


def _shown(default: Any) -> str:
    """Return a default as a user would type it; nothing for a flag and for what may be left out."""
    return "" if default is None or isinstance(default, bool) or default == "" else f"`{default}`"
