"""Documentation, docstrings, comments and messages are in plain technical English: the words of `BANNED` do not occur in them."""

from __future__ import annotations

import ast
import io
import json
import re
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILES = (
    *("*.md", "docs/**/*.md", "docs/**/*.ipynb", "docs/*.py", "dcrb_ros/**/*.py", "dcrb_ros/**/*.md", "launch/*.py", "setup.py"),
    *("config/**/*.yaml", "examples/**/*.py", "examples/**/*.yaml", "examples/**/*.xml", "package.xml", "mkdocs.yml", "Makefile"),
)
"""Files that are read, as patterns; the changelog is history and exempt."""

BANNED = {
    r"\btold\b|\btells? [^.,;:]{1,25}\b(?:apart|from)\b": "is distinguished from, distinguishes",
    r"\bow(?:e|es|ed)\b": "due to, required",
    r"\bspoil(?:s|ed|t|ing)?\b": "damaged, invalid, with a false alarm",
    r"\bheed(?:s|ed|ing)?\b": "handles",
    r"\bstor(?:y|ies)\b": "timeline, sequence",
    r"\b(?:feel|feels|felt|feeling)\b": "follows, transmits, is subject to",
    r"\bhurr(?:y|ies|ied|ying)\b": "closes fast",
    r"(?<![Tt]here )(?<!law )\b(?:is|are|was|were) none\b": "is missing, is invalid, does not exist",
    r"\b(?:knows|knew)\b": "has, receives, is trained on",
    r"\b(?:stands|stood)\b(?! (?:for|out)\b)": "is, applies, is at rest",
    r"\bsees\b": "receives, measures, has access to",
    r"\b(?:hears?|heard)\b": "measures, rises above the noise",
    r"\b[Ff]org(?:ets?|ot|otten)\b": "discards, decays",
    r"\b(?:pays?|paid)\b": "is corrected for, is worth while",
    r"\bwants?\b": "requires, expects",
    r"\bwhom\b|\bthat which\b": "a noun and a relative clause",
    r"\bobeys?\b|\blets? go of\b": "executes; releases",
    r"\bof (?:before|above|below)\b": "the earlier noun itself",
    r"\bwhat [^.,;:|]{1,30} of that\b": "a noun",
    r"\b(?:[Ww]hat|that) travels with\b": "modulation at",
    r"\b(?:machines?|bearings?|rigs?) that no \w+ has seen\b": "held-out",
}
"""Words and phrases of ours that a reader has to guess, as patterns, and what to write."""

HISTORY = r"\b[Aa]n earlier version\b|\b[Ff]ormerly\b|\bdetector before\b|\bused to have\b|\bhad been seen\b"
"""Phrases about former states, which belong into the changelog."""


def prose(name: str, text: str) -> str:
    """Return what is meant for readers: the text of a page, the comments and strings of a program, without the breaks of its lines."""
    if name.endswith(".ipynb"):
        text = "\n".join("".join(cell["source"]) for cell in json.loads(text)["cells"])
    elif name.endswith(".py"):
        strings = [node.value for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Constant) and isinstance(node.value, str)]
        tokens = tokenize.generate_tokens(io.StringIO(text).readline)
        comments = [token.string.lstrip("# ") for token in tokens if token.type == tokenize.COMMENT]
        text = "\n".join(strings) + "\n\n" + "\n".join(comments)
    return " ".join(text.replace("\n# ", "\n").split())


def banned_words(name: str, text: str) -> list[str]:
    """Return each banned word of a file with its surroundings and a proposal."""
    page = name.startswith("docs/") or name.endswith(".md")
    words = BANNED | ({HISTORY: "move it to CHANGELOG.rst"} if page else {})
    text = prose(name, text)
    return [
        f"{name}: '{text[max(0, hit.start() - 30) : hit.end() + 30]}': write '{remedy}'"
        for pattern, remedy in words.items()
        for hit in re.finditer(pattern, text)
    ]


def test_no_banned_word_is_in_documentation_docstrings_or_messages() -> None:
    files = sorted({path for pattern in FILES for path in ROOT.glob(pattern)})
    assert len(files) > 300
    names = {path: path.relative_to(ROOT).as_posix() for path in files}
    assert [hit for path in files for hit in banned_words(names[path], path.read_text(encoding="utf-8"))] == []


@pytest.mark.parametrize(
    ("name", "text", "hits"),
    [
        ("docs/page.md", "The two cannot be told\napart.", 1),
        ("docs/page.md", "An earlier version of this page said so.", 1),
        ("dcrb_ros/a.py", '"""What a roller feels."""  # which the page knows', 2),
        ("dcrb_ros/a.py", 'feels = f"{3} is none: {feels}"', 1),
        ("dcrb_ros/a.py", '"""Forget the hops."""', 1),
        ("examples/a.yaml", "# The user\n# knows it.", 1),
        ("docs/page.md", "There is none. `*` stands for any name, each line stands out, and you know it.", 0),
        ("dcrb_ros/a.py", "knows = None  # an earlier version", 0),
    ],
)
def test_banned_words_are_found_in_prose_only(name: str, text: str, hits: int) -> None:
    assert len(banned_words(name, text)) == hits
