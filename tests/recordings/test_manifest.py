"""The manifest: what a recording states about its model and its samples."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from made_up_blocks import BODIES, blocks

from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import MANIFEST, Message
from dcrb_ros.recordings import manifest
from dcrb_ros.recordings.manifest import MODEL, OUTCOME, Outcome, model_fingerprint, opening
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.stream.events import SpeedCommand, TimedCommand

RATE = 51200


def encoded(first: int, last: int) -> Iterable[Message]:
    """Return the messages of the blocks ``first`` to ``last - 1``."""
    encoder = BlockEncoder(Configuration(), BODIES)
    return [message for block in list(blocks(last))[first:] for message in encoder.encode(block)]


def outcome_of(messages: Iterable[Message]) -> Outcome:
    outcome = Outcome(RATE)
    for message in messages:
        outcome.add(message)
    return outcome


def ending(outcome: Outcome) -> dict[str, object]:
    found: dict[str, object] = json.loads(outcome.records()[OUTCOME]["outcome"])
    return found


def test_the_format_of_the_manifest_is_2() -> None:
    assert json.loads(opening(Configuration(), BODIES, "/dcrb")[MANIFEST]["manifest"])["format"] == 2


def test_the_fingerprint_depends_on_every_source_of_the_model_and_on_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fingerprint = model_fingerprint.__wrapped__
    known = fingerprint()
    monkeypatch.setattr(manifest, "__file__", str(tmp_path / "recordings" / "manifest.py"))
    found = [fingerprint()]
    assert found[0] != known
    for folder in MODEL:
        (tmp_path / folder / "part").mkdir(parents=True)
        for name in ("a.py", "part/b.py"):
            (tmp_path / folder / name).write_text(f"{folder}/{name}")
            found.append(fingerprint())
    assert len(set(found)) == len(found)
    for name in ("c.py", "core/d.txt"):
        (tmp_path / name).write_text("not of the model")
        assert fingerprint() == found[-1]
    assert {len(one) for one in found} == {16}


def test_an_outcome_without_samples_is_zero() -> None:
    outcome = Outcome(RATE)
    assert (outcome.first_index, outcome.samples, outcome.end_index) == (None, 0, 0)
    assert outcome.sha256 == hashlib.sha256().hexdigest()
    about = ending(outcome)
    assert [about[name] for name in ("first_index", "samples", "end_index", "command_count")] == [0, 0, 0, 0]


def test_range_and_hash_are_those_of_the_samples() -> None:
    outcome = outcome_of(encoded(5, 9))
    samples = np.concatenate([np.column_stack([block.acceleration, block.shaft_angle]) for block in list(blocks(9))[5:]])
    assert (outcome.first_index, outcome.samples, outcome.end_index) == (5 * 1024, 4 * 1024, 9 * 1024)
    assert outcome.sha256 == hashlib.sha256(samples.astype("<f4").tobytes()).hexdigest()
    about = ending(outcome)
    assert [about[name] for name in ("first_index", "samples", "end_index")] == [5 * 1024, 4 * 1024, 9 * 1024]


def test_an_outcome_can_be_read_while_samples_are_added() -> None:
    outcome = Outcome(RATE)
    for number in range(2, 5):
        for message in encoded(number, number + 1):
            outcome.add(message)
        assert (outcome.first_index, outcome.samples, outcome.end_index) == (2048, 1024 * (number - 1), 1024 * (number + 1))


@pytest.mark.parametrize("excess", [0, 1])
def test_commands_are_listed_up_to_the_largest_record(excess: int, monkeypatch: pytest.MonkeyPatch) -> None:
    outcome = Outcome(RATE, [TimedCommand(k, SpeedCommand(float(k))) for k in range(10)])
    size = len(outcome.records()[OUTCOME]["outcome"])
    monkeypatch.setattr(manifest, "MAX_RECORD", size - excess)
    about = ending(outcome)
    assert about["command_count"] == 10
    assert about["commands"] is None if excess else len(about["commands"]) == 10  # type: ignore[arg-type]
