"""YAML for settings: duplicate keys and huge expansions are refused, 1e-5 is a number, and every error is one sentence."""

from __future__ import annotations

import itertools
from collections.abc import Hashable
from pathlib import Path
from typing import Any, NoReturn

import yaml

from dcrb_ros.schema.refusal import Refusal

LARGEST_FILE = 1_000_000
"""Largest configuration file [bytes]; typical ones have a few hundred."""
MOST_EXPANDED = 2 * LARGEST_FILE
"""Limit of the characters and values of a file after its aliases are expanded; without aliases `LARGEST_FILE` bytes cannot exceed it."""
MOST_BITS = 1000
"""Longest integer [bits] that converts to a float and that Python prints."""


class _Loader(yaml.SafeLoader):
    """YAML loader that refuses duplicate keys and reads numbers such as 1e-5, which are text in YAML 1.1."""

    def get_single_node(self) -> Any:
        """Return the document; refuse aliases of aliases that expand a small file to billions of values."""
        node = super().get_single_node()
        if node is not None and _expanded(node, {}) > MOST_EXPANDED:
            _refuse(f"its aliases expand to more than {MOST_EXPANDED} values", node)
        return node

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        """Return a value; PyYAML raises many types of errors for invalid ones, such as the date 2026-13-45."""
        try:
            value = super().construct_object(node, deep=deep)
        except (ValueError, TypeError, ArithmeticError, LookupError, AttributeError):
            _refuse(f"'{str(node.value)[:40]}' cannot be read as {node.tag.rpartition(':')[2]}; put a text in quotes", node)
        if isinstance(value, int) and value.bit_length() > MOST_BITS:
            _refuse(f"'{str(node.value)[:40]}...' is too large a number", node)
        return value


def _refuse(words: str, node: yaml.Node) -> NoReturn:
    raise yaml.constructor.ConstructorError(None, None, words, node.start_mark)


def _expanded(node: yaml.Node, known: dict[yaml.Node, int]) -> int:
    """Return the number of characters and values of a node after expansion; a node within itself counts once."""
    if node not in known:
        known[node] = 1
        inside = itertools.chain.from_iterable(node.value) if isinstance(node, yaml.MappingNode) else node.value
        known[node] += len(inside) if isinstance(inside, str) else sum(_expanded(child, known) for child in inside)
    return known[node]


def _mapping(loader: _Loader, node: yaml.MappingNode) -> dict[Any, Any]:
    keys = [loader.construct_object(key, deep=True) for key, _ in node.value]
    seen: set[Any] = set()
    for key, (of, _) in zip(keys, node.value, strict=True):
        if not isinstance(key, Hashable):
            _refuse("a key is a list or a mapping; it must be a word", of)
        if key in seen:
            _refuse(f"the key '{key}' occurs twice", node)
        seen.add(key)
    return {key: loader.construct_object(value, deep=True) for key, (_, value) in zip(keys, node.value, strict=True)}


def _number(text: str) -> float | str:
    """Return a text as a number where it is one."""
    try:
        return float(text)
    except ValueError:
        return text


_Loader.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _mapping)


def _text(loader: _Loader, node: yaml.ScalarNode) -> float | str:
    plain = node.style is None and node.value[:1] in "+-.0123456789"
    return _number(node.value) if plain else str(node.value)


_Loader.add_constructor("tag:yaml.org,2002:str", _text)


def read_yaml(path: Path) -> Any:
    """Return the content of a YAML file.

    Raises:
        Refusal: the file is too large, cannot be read or is not YAML.
    """
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise Refusal(f"{path} has {path.stat().st_size} bytes; the limit is {LARGEST_FILE}")
        return parsed(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise Refusal(f"{path} cannot be read: {error.strerror}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f" in line {mark.line + 1}" if mark else ""
        raise Refusal(f"{path} is not valid YAML{where}: {getattr(error, 'problem', None) or 'not a text file'}") from None


def parsed(text: str) -> Any:
    """Return the value of a YAML text.

    Raises:
        yaml.YAMLError: for any error in the text.
    """
    try:
        return yaml.load(text, Loader=_Loader)
    except RecursionError:
        raise yaml.MarkedYAMLError(problem="it is nested too deeply") from None
    except (ValueError, OverflowError):
        raise yaml.MarkedYAMLError(problem="it names a character that does not exist") from None
