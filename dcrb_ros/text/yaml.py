"""YAML from outside: size, number of values, nesting and aliases are limited, and numbers have one form.

Duplicate keys are refused. A number is decimal, hexadecimal or binary: 1e-5 is a number, as in YAML 1.2. Forms of YAML 1.1 that other
readers take differently, 1:30 for 90 and 010 for 8, are text.
"""

from __future__ import annotations

import contextlib
import gc
import itertools
import re
from collections.abc import Hashable, Iterator
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, NoReturn

import yaml

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.files import LARGEST_TEXT, read_text

BYTES_PER_VALUE = 10
"""Bytes of a file for each value that it may have; typical files have 20."""
MOST_EXPANDED = 2
"""Limit of the characters and values of a text after its aliases are expanded, relative to those of a text without aliases."""
DEEPEST = 100
"""Deepest nesting [-], with aliases expanded."""
TOO_DEEP = f"it is nested too deeply: more than {DEEPEST} levels"
NESTED_FOR_LIBYAML = "exceeded maximum nesting depth"
"""What libyaml 0.2.6 says of flow collections nested more than 1000 deep, which it meets before it gives an event."""
MOST_BITS = 1000
"""Longest integer [bits] that converts to a float and that Python prints."""
MOST_DIGITS = 1000
"""Longest decimal number [characters]."""

MERGE = "tag:yaml.org,2002:merge"
"""Tag of the key that takes the values of another mapping in YAML 1.1."""

_PARSER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""The parser of libyaml, ten times as fast, where PyYAML has it."""


class _Extent(NamedTuple):
    """The size of a node with its aliases expanded."""

    values: int
    characters: int
    depth: int


class _Loader(_PARSER):
    """YAML loader that refuses duplicate keys and reads numbers as YAML 1.2 does."""

    largest = LARGEST_TEXT
    has_aliases = True
    yaml_implicit_resolvers: ClassVar[dict[str, Any]] = {
        first: [(tag, form) for tag, form in forms if tag not in ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")]
        for first, forms in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }

    def get_single_node(self) -> Any:
        """Return the document; refuse aliases of aliases that expand a small text to billions of values."""
        node = super().get_single_node()
        if node is None or not self.has_aliases:
            return node
        values, characters, depth = _extent(node, {})
        most = MOST_EXPANDED * _most_values(self.largest)
        if values > most:
            _refuse(f"its aliases expand to more than {most} values", node)
        if characters > MOST_EXPANDED * self.largest:
            _refuse(f"its aliases expand to more than {MOST_EXPANDED * self.largest} characters", node)
        if depth > DEEPEST:
            _refuse(TOO_DEEP, node)
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


def _most_values(largest: int) -> int:
    return largest // BYTES_PER_VALUE


def _extent(node: yaml.Node, known: dict[yaml.Node, _Extent | None]) -> _Extent:
    """Return the extent of a node; an anchor precedes its aliases, so the recursion is as deep as the text is nested."""
    if node not in known:
        known[node] = None
        inside = itertools.chain.from_iterable(node.value) if isinstance(node, yaml.MappingNode) else node.value
        if isinstance(inside, str):
            known[node] = _Extent(1, len(inside), 0)
        else:
            values, characters, depths = zip(_Extent(1, 0, 0), *(_extent(child, known) for child in inside), strict=True)
            known[node] = _Extent(sum(values), sum(characters), max(depths) + 1)
    extent = known[node]
    if extent is None:
        _refuse("it contains itself by an alias", node)
    return extent


def _mapping(loader: _Loader, node: yaml.MappingNode) -> dict[Any, Any]:
    keys = [loader.construct_object(key, deep=True) for key, _ in node.value]
    seen: set[Any] = set()
    for key, (key_node, _) in zip(keys, node.value, strict=True):
        if not isinstance(key, Hashable):
            _refuse("a key is a list or a mapping; it must be a word", key_node)
        if key in seen:
            _refuse(f"the key '{key}' occurs twice", key_node)
        seen.add(key)
    return {key: loader.construct_object(value, deep=True) for key, (_, value) in zip(keys, node.value, strict=True)}


INTEGER = re.compile(r"[-+]?(?:0|[1-9][0-9_]*|0x[0-9a-fA-F_]+|0b[01_]+)$")
FLOAT = re.compile(r"[-+]?\.(?:inf|Inf|INF)$|\.(?:nan|NaN|NAN)$")
DECIMAL = re.compile(r"[-+]?(?:(?:0|[1-9][0-9_]*)(?:\.[0-9_]*)?|\.[0-9][0-9_]*)(?:[eE][-+]?[0-9]+)?$")
"""Decimal numbers that `float` reads; those that YAML 1.1 takes for text, such as 1e-5, are among them."""

_Loader.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _mapping)
_Loader.add_implicit_resolver("tag:yaml.org,2002:int", INTEGER, list("-+0123456789"))
_Loader.add_implicit_resolver("tag:yaml.org,2002:float", FLOAT, list("-+."))


def _text(loader: _Loader, node: yaml.ScalarNode) -> float | str:
    plain = node.style in (None, "") and len(node.value) <= MOST_DIGITS and DECIMAL.match(node.value)
    return float(node.value.replace("_", "")) if plain else str(node.value)


def _untyped(loader: _Loader, node: yaml.Node) -> NoReturn:
    """Refuse a tag that has no type here, such as that of a merge key."""
    if node.tag == MERGE:
        _refuse("merge keys (<<) are not read: write out the values, or put a text in quotes", node)
    _refuse(f"the tag '{node.tag}' is not read: give a plain number, text, list or mapping", node)


_Loader.add_constructor("tag:yaml.org,2002:str", _text)
for kind in (None, *(f"tag:yaml.org,2002:{name}" for name in ("set", "omap", "pairs", "binary"))):
    _Loader.add_constructor(kind, _untyped)


class _Dumper(yaml.SafeDumper):
    """YAML writer that quotes texts that `read_yaml` would take for numbers, such as 12e4, which PyYAML reads as text."""


_Dumper.add_implicit_resolver("tag:yaml.org,2002:float", DECIMAL, list("-+.0123456789"))


def yaml_text(tree: Any, *, width: float = 80, unicode: bool = False) -> str:
    """Return a YAML text of the tree, with keys in its order and lines of some ``width``, that `read_yaml` reads back."""
    return str(yaml.dump(tree, Dumper=_Dumper, sort_keys=False, width=width, allow_unicode=unicode))


def read_yaml(path: Path, largest: int = LARGEST_TEXT) -> Any:
    """Return the content of a YAML file of at most ``largest`` bytes.

    Raises:
        Refusal: the file is too large, cannot be read or is not YAML, or what it contains exceeds a limit of this module.
    """
    try:
        return parsed(read_text(path, largest), largest)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f" in line {mark.line + 1}" if mark else ""
        raise Refusal(f"{path} is not valid YAML{where}: {getattr(error, 'problem', None) or error}") from None


def parsed(text: str, largest: int = LARGEST_TEXT) -> Any:
    """Return the value of a YAML text of at most ``largest`` characters.

    Raises:
        yaml.YAMLError: for any error in the text.
    """
    if len(text) > largest:
        raise yaml.MarkedYAMLError(problem=f"it has {len(text)} characters; at most {largest} are read")
    try:
        aliases = _count_aliases(text, _most_values(largest))
        loader = _Loader(text)
        loader.largest, loader.has_aliases = largest, aliases > 0
        try:
            with _collection_paused():
                return loader.get_single_data()
        finally:
            loader.dispose()
    except RecursionError:
        raise yaml.MarkedYAMLError(problem="it is nested too deeply") from None
    except yaml.MarkedYAMLError as error:
        if error.problem != NESTED_FOR_LIBYAML:
            raise
        raise yaml.MarkedYAMLError(problem=TOO_DEEP, problem_mark=error.problem_mark) from None
    except yaml.reader.ReaderError as error:
        line = text.encode(errors="replace")[: error.position].count(b"\n")  # libyaml counts bytes
        problem = f"it contains the control character U+{error.character:04X}: remove it"
        raise yaml.MarkedYAMLError(problem=problem, problem_mark=yaml.Mark("", error.position, line, 0, None, 0)) from None
    except (ValueError, OverflowError):
        raise yaml.MarkedYAMLError(problem="it names a character that does not exist") from None


@contextlib.contextmanager
def _collection_paused() -> Iterator[None]:
    """Pause the search for reference cycles: nodes have no cycles, and the search of 90 000 takes three times as long as their reading."""
    paused = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if paused:
            gc.enable()


def _count_aliases(text: str, most: int) -> int:
    """Return the number of aliases in a text.

    A text with more than ``most`` values, or one that is nested too deeply, is refused before anything is built of it.
    """
    values = depth = aliases = 0
    event: Any
    for event in yaml.parse(text, Loader=_PARSER):
        values += isinstance(event, yaml.NodeEvent)
        aliases += isinstance(event, yaml.AliasEvent)
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if values > most:
            raise yaml.MarkedYAMLError(problem=f"it has more than {most} values", problem_mark=event.start_mark)
        if depth > DEEPEST:
            raise yaml.MarkedYAMLError(problem=TOO_DEEP, problem_mark=event.start_mark)
    return aliases
