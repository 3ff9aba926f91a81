"""YAML as people write settings: no key twice, exponents without a point, no bombs; whatever is wrong with a file is one sentence."""

from __future__ import annotations

import itertools
from collections.abc import Hashable
from pathlib import Path
from typing import Any, NoReturn

import yaml

from dcrb_ros.runtime.refusal import Refusal

LARGEST_FILE = 1_000_000
"""Largest configuration file [bytes]; real ones have a few hundred."""
MOST_UNFOLDED = 2 * LARGEST_FILE
"""Most characters and values that a file stands for with its aliases put in; without aliases none of `LARGEST_FILE` has more."""
MOST_BITS = 1000
"""Longest whole number [bits]: a float still holds it, and Python writes it out."""


class _Loader(yaml.SafeLoader):
    """YAML without duplicate keys, and with numbers such as 1e-5, which YAML 1.1 would read as text."""

    def get_single_node(self) -> Any:
        """Return the document; a small one may stand for billions of values by aliases of aliases."""
        node = super().get_single_node()
        if node is not None and _unfolded(node, {}) > MOST_UNFOLDED:
            _refuse(f"its aliases stand for more than {MOST_UNFOLDED} values", node)
        return node

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        """Return a value; what only looks like one, such as the date 2026-13-45, makes PyYAML fail in many ways."""
        try:
            value = super().construct_object(node, deep=deep)
        except (ValueError, TypeError, ArithmeticError, LookupError, AttributeError):
            _refuse(f"'{str(node.value)[:40]}' cannot be read as {node.tag.rpartition(':')[2]}; a text stands in quotes", node)
        if isinstance(value, int) and value.bit_length() > MOST_BITS:
            _refuse(f"'{str(node.value)[:40]}...' is too large a number", node)
        return value


def _refuse(words: str, node: yaml.Node) -> NoReturn:
    raise yaml.constructor.ConstructorError(None, None, words, node.start_mark)


def _unfolded(node: yaml.Node, known: dict[yaml.Node, int]) -> int:
    """Return how many characters and values a node stands for; one that holds itself counts once."""
    if node not in known:
        known[node] = 1
        inside = itertools.chain.from_iterable(node.value) if isinstance(node, yaml.MappingNode) else node.value
        known[node] += len(inside) if isinstance(inside, str) else sum(_unfolded(child, known) for child in inside)
    return known[node]


def _mapping(loader: _Loader, node: yaml.MappingNode) -> dict[Any, Any]:
    keys = [loader.construct_object(key, deep=True) for key, _ in node.value]
    seen: set[Any] = set()
    for key, (of, _) in zip(keys, node.value, strict=True):
        if not isinstance(key, Hashable):
            _refuse("a key is a list or a mapping; it must be a plain word", of)
        if key in seen:
            _refuse(f"the key '{key}' stands twice", node)
        seen.add(key)
    return {key: loader.construct_object(value, deep=True) for key, (_, value) in zip(keys, node.value, strict=True)}


def _number(text: str) -> float | str:
    """Return a plain scalar with an exponent as a number."""
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
    """Return what a YAML file holds, without duplicate keys and with exponents read as numbers.

    Raises:
        Refusal: the file is too large, cannot be read or is no YAML.
    """
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise Refusal(f"{path} has {path.stat().st_size} bytes; a file of settings has at most {LARGEST_FILE}")
        return parsed(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise Refusal(f"{path} cannot be read: {error.strerror}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f" in line {mark.line + 1}" if mark else ""
        raise Refusal(f"{path} is not valid YAML{where}: {getattr(error, 'problem', None) or 'not a text file'}") from None


def parsed(text: str) -> Any:
    """Return what YAML says; whatever is wrong with it is a `yaml.YAMLError`."""
    try:
        return yaml.load(text, Loader=_Loader)
    except RecursionError:
        raise yaml.MarkedYAMLError(problem="it is nested too deeply") from None
    except (ValueError, OverflowError):
        raise yaml.MarkedYAMLError(problem="it names a character that does not exist") from None
