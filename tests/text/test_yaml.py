"""YAML from outside: what is a number, and which texts are refused."""

from __future__ import annotations

import gc
import math
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.yaml import DEEPEST, parsed, read_yaml, yaml_text


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("90", 90),
        ("-3", -3),
        ("1_000", 1000),
        ("0x1F", 31),
        ("0b11", 3),
        ("1e-5", 1e-5),
        ("+1.5E3", 1500.0),
        ("1.", 1.0),
        ("-.5", -0.5),
        (".inf", math.inf),
        ("'12'", "12"),
        ("on", True),
        ("~", None),
    ],
)
def test_numbers_and_constants_are_read(text: str, value: Any) -> None:
    found = parsed(text)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize("text", ["1:30", "190:20:30", "1:30.5", "-1:30", "010", "08", "-007", "00.5", "1e5x", "9" * 2000 + ".0"])
def test_forms_that_readers_take_differently_are_text(text: str) -> None:
    assert parsed(f"a: {text}") == {"a": text}


@given(st.floats(allow_nan=False), st.integers(-(2**900), 2**900))
def test_numbers_as_python_prints_them_are_read(number: float, whole: int) -> None:
    assert parsed(yaml.safe_dump([number, whole])) == [number, whole]
    assert parsed(f"[{whole}]") == [whole]
    if math.isfinite(number):
        assert parsed(f"[{number!r}]") == [number]


@pytest.mark.parametrize("text", ["".join(f"k{number}: 1\n" for number in range(40_000)), "[1, 2"])
def test_the_collector_is_paused_while_a_text_is_read(text: str) -> None:
    collections: list[str] = []

    def count(phase: str, info: dict[str, int]) -> None:
        if info["generation"]:
            collections.append(phase)

    gc.callbacks.append(count)
    try:
        parsed(text)
    except yaml.YAMLError:
        pass
    finally:
        gc.callbacks.remove(count)
    assert gc.isenabled()
    assert len(collections) <= 4  # One while the events are counted, one afterwards.


def nested(levels: int) -> str:
    return "[" * levels + "]" * levels


def chained(levels: int) -> str:
    return "- &a0 []\n" + "".join(f"- &a{k} [*a{k - 1}]\n" for k in range(1, levels))


@pytest.mark.parametrize("form", [nested, chained])
def test_nesting_is_limited_with_and_without_aliases(form: Any) -> None:
    below = DEEPEST - (form is chained)
    parsed(form(below))
    with pytest.raises(yaml.YAMLError, match=f"nested too deeply: more than {DEEPEST} levels"):
        parsed(form(below + 1))


def test_the_number_of_values_is_limited_in_proportion_to_the_size() -> None:
    assert len(parsed("[" + "1," * 99 + "]", 1000)) == 99
    with pytest.raises(yaml.YAMLError, match="it has more than 100 values"):
        parsed("[" + "1," * 100 + "]", 1000)


def test_aliases_are_limited_in_values_and_in_characters() -> None:
    with pytest.raises(yaml.YAMLError, match="its aliases expand to more than 200 values"):
        parsed("- &a [" + "1," * 50 + "]\n- [*a, *a, *a, *a]", 1000)
    with pytest.raises(yaml.YAMLError, match="its aliases expand to more than 2000 characters"):
        parsed(f"- &a {'x' * 600}\n- [*a, *a, *a]", 1000)
    with pytest.raises(yaml.YAMLError, match="contains itself"):
        parsed("&a [*a]")


def test_a_file_is_refused_with_its_name_the_figure_and_the_limit(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("a: [" + "1, " * 40 + "]")
    with pytest.raises(Refusal, match=r"a\.yaml has 125 bytes; at most 100 are read"):
        read_yaml(path, 100)
    with pytest.raises(Refusal, match=r"a\.yaml is not valid YAML in line 1: it has more than 12 values"):
        read_yaml(path, 125)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("base: &b {speed: 1}\noperating:\n  <<: *b\n", "in line 3: merge keys (<<) are not read: write out the values"),
        ("a: !speed 3", "in line 1: the tag '!speed' is not read: give a plain number, text, list or mapping"),
        ("a: !!python/object/apply:os.system [ls]", "the tag 'tag:yaml.org,2002:python/object/apply:os.system' is not read"),
        ("a: !!set {x, y}", "the tag 'tag:yaml.org,2002:set' is not read"),
        ("a: !!binary aGk=", "the tag 'tag:yaml.org,2002:binary' is not read"),
        ("a: =", "the tag 'tag:yaml.org,2002:value' is not read"),
    ],
)
def test_tags_and_merge_keys_are_refused_in_plain_words(text: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(Refusal, match="is not valid YAML") as refused:
        read_yaml(path)
    assert words in str(refused.value)


def test_a_control_character_is_refused_in_one_line_with_its_place(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("\u00e9: 1\nb: \x07\n", encoding="utf-8")
    with pytest.raises(Refusal, match=r"a\.yaml is not valid YAML in line 2: it contains the control character U\+0007: remove it$"):
        read_yaml(path)


@given(st.text(alphabet="0123456789eE+-._xb:", max_size=14) | st.integers() | st.floats(allow_nan=False))
def test_what_is_written_is_read_back(value: str | float) -> None:
    found = parsed(yaml_text({"value": value}))["value"]
    assert (found, type(found)) == (value, type(value))


def test_a_hash_that_looks_like_a_number_stays_a_text() -> None:
    assert parsed(yaml_text({"rules": "12345678e123"})) == {"rules": "12345678e123"}
