"""The digest that a recording states is compared with its samples wherever a result is made from them."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Callable
from html import unescape
from pathlib import Path

import pytest
from altered_recording import altered
from made_up_blocks import recorded
from separate_process import dcrb

import dcrb_ros
from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.topics import MANIFEST, NAMESPACE, VIBRATION
from dcrb_ros.recordings.manifest import DIGEST, OUTCOME
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import channel_of
from dcrb_ros.recordings.recovery import described_channel, recover
from dcrb_ros.recordings.reproduction import NotReproduced, Reproduction
from dcrb_ros.recordings.splitting import Bag
from dcrb_ros.recordings.storage import valid_files
from dcrb_ros.recordings.verification import RECOVERY, digest_mismatch, recovered, unsigned
from dcrb_ros.schema.refusal import AlteredSamples

SENTENCE = "the recording's samples do not match its own digest"


@pytest.fixture(scope="module")
def intact(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("bags") / "intact", 60)


@pytest.fixture(scope="module")
def flipped(intact: Path) -> Path:
    return altered(intact, intact.with_name("flipped"))


def test_a_flipped_bit_in_each_block_is_a_mismatch(intact: Path, flipped: Path) -> None:
    assert digest_mismatch(Recording(intact)) == ""
    assert Recording(intact).digests().match is True
    digests = Recording(flipped).digests()
    assert Recording(flipped).complete
    assert digests.match is False
    assert digests.read.count == 60 * 1024
    assert SENTENCE in digests.mismatch


def test_later_files_of_a_split_recording_are_not_compared(tmp_path: Path) -> None:
    files = Recording(recorded(tmp_path / "bag", 60, split_duration=0.5)).files
    assert len(files) > 1
    assert Recording(tmp_path / "bag").digests().match is True
    assert [Recording(file).digests().match for file in files] == [True, *[None] * (len(files) - 1)]


def test_a_later_file_is_known_by_another_name(tmp_path: Path) -> None:
    later = Recording(recorded(tmp_path / "bag", 60, split_duration=0.5)).files[1].rename(tmp_path / "first_0.mcap")
    assert Recording(later).digests().match is None


def test_a_recording_whose_beginning_was_removed_is_a_mismatch(intact: Path, tmp_path: Path) -> None:
    path = altered(intact, tmp_path / "bag", lambda data: data if decode_vibration(data).stamp_ns >= 100_000_000 else None)
    assert Recording(path).complete
    assert Recording(path).waveform().index[0] == 5 * 1024
    assert "contains 56320 with" in digest_mismatch(Recording(path))


def test_a_recording_without_the_waveform_is_not_compared(tmp_path: Path) -> None:
    digests = Recording(recorded(tmp_path / "bag", 3, topics="outer_ring/features")).digests()
    assert (digests.match, digests.mismatch) == (None, "")


def test_info_shows_the_stated_and_the_actual_digest_and_detect_a_mismatch(intact: Path, flipped: Path) -> None:
    stated = (Recording(intact).outcome or {})["sha256"]
    for bag, match in ((intact, True), (flipped, False)):
        about = json.loads(dcrb("info", str(bag), "--json").stdout)
        assert about["samples"]["stated_sha256"] == stated
        assert (about["samples"]["actual_sha256"] == stated) is match
        assert about["samples"]["match"] is match
        assert (SENTENCE in " ".join(about["damage"])) is not match
        mismatch = json.loads(dcrb("detect", str(bag), "--json").stdout)["mismatch"]
        assert mismatch is None if match else mismatch.startswith(SENTENCE)
        words = dcrb("info", str(bag)).stdout
        assert f"stated sha256 {stated}" in words
        assert ("NOT as stated" in words) is not match


@pytest.mark.slow
@pytest.mark.parametrize("command", ["detect", "score", "export", "recover", "plot", "calibrate", "compare", "view"])
def test_commands_warn_of_samples_that_do_not_match(command: str, intact: Path, flipped: Path, tmp_path: Path) -> None:
    for bag in (intact, flipped):
        output = {
            "score": ["--reference"],
            "export": ["-o", f"{tmp_path}/{bag.name}.npz"],
            "recover": ["-o", f"{tmp_path}/{bag.name}"],
            "plot": ["-o", f"{tmp_path}/{bag.name}.png"],
            "calibrate": ["-o", f"{tmp_path}/{bag.name}.yaml"],
            "compare": [str(intact)],
            "view": ["--save", f"{tmp_path}/{bag.name}.rrd"],
        }
        done = dcrb(command, str(bag), *output.get(command, []))
        assert done.stderr.count(SENTENCE) == (bag == flipped), done.stderr


READS: dict[str, Callable[[Recording], object]] = {
    "detect": dcrb_ros.detect,
    "waveform": Recording.waveform,
    "a part of the waveform": lambda recording: recording.waveform(0.2, 0.3),
    "acceleration": lambda recording: recording.acceleration,
    "envelope_spectrum": dcrb_ros.envelope_spectrum,
    "features": dcrb_ros.extract_features,
    "vibrations": lambda recording: list(recording.vibrations()),
}
"""Ways to a result from a recording in Python."""


@pytest.mark.parametrize("way", READS)
def test_reading_samples_that_do_not_match_warns_once(way: str, intact: Path, flipped: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        READS[way](Recording(intact))
    with pytest.warns(AlteredSamples, match=f"^{re.escape(str(flipped))}: {SENTENCE}") as caught:
        READS[way](Recording(flipped))
    assert len([warning for warning in caught if warning.category is AlteredSamples]) == 1


def test_digests_are_those_that_were_computed_with_the_waveform(flipped: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    recording = Recording(flipped)
    with pytest.warns(AlteredSamples):
        recording.waveform()
    monkeypatch.setattr(Recording, "messages", None)
    assert recording.digests().match is False


def test_a_reproduction_says_that_the_recording_was_changed(flipped: Path) -> None:
    reproduction = Reproduction(Recording(flipped))
    with pytest.raises(NotReproduced, match=f"{SENTENCE}: it states 61440 samples with sha256 [0-9a-f]{{12}}, and contains 61440 with"):
        reproduction.check()


def unsigned_copy(source: Path, target: Path, **changes: object) -> Path:
    """Copy a recording with other entries of the manifest and without digests in its records, as those of earlier versions are."""
    opening, closing = dict[str, dict[str, str]](), dict[str, dict[str, str]]()
    recording = Recording(source)
    for record in recording.stored[0].metadata():
        if record.name in (MANIFEST, OUTCOME):
            (key,) = record.metadata
            content = {name: value for name, value in json.loads(record.metadata[key]).items() if name != DIGEST}
            manifest = record.name == MANIFEST
            (opening if manifest else closing)[record.name] = {key: json.dumps(content | (changes if manifest else {}))}
    bag = Bag(target, opening=opening, closing=lambda: closing)
    for stored in recording.stored[0].messages([]):
        assert stored.schema is not None
        bag.write([(described_channel(stored.channel, stored.schema), stored.message.log_time, stored.message.data)])
    bag.close()
    return target


def test_a_recording_without_digests_is_used_and_called_unverified(intact: Path, tmp_path: Path) -> None:
    old = unsigned_copy(intact, tmp_path / "old", dcrb_ros="0.0.1")
    assert Recording(old).complete
    assert unsigned(Recording(intact)) == ""
    sentence = "unverified: no digest in manifest and outcome record (dcrb_ros 0.0.1)"
    for command, output in {"detect": [], "export": ["-o", f"{tmp_path}/old.npz"], "score": ["--reference"]}.items():
        done = dcrb(command, str(old), *output)
        assert done.stderr.count(f"note: {old}: {sentence}") == 1, done.stderr
    assert json.loads(dcrb("detect", str(old), "--json").stdout)["unverified"].startswith(sentence)
    assert json.loads(dcrb("info", str(old), "--json").stdout)["unverified"].startswith(sentence)
    assert sentence in dcrb("info", str(old)).stdout
    assert json.loads(dcrb("info", str(intact), "--json").stdout)["unverified"] is None


def test_a_report_says_what_is_wrong_with_a_digest(intact: Path, flipped: Path, tmp_path: Path) -> None:
    old = unsigned_copy(intact, tmp_path / "old")
    for bag, sentence in ((intact, ""), (flipped, SENTENCE), (old, "unverified: no digest in manifest and outcome record")):
        page = tmp_path / f"{bag.name}.html"
        dcrb("detect", str(bag), "--report", str(page))
        found = [words for words in (SENTENCE, "unverified: ") if words in unescape(page.read_text(encoding="utf-8"))]
        assert bool(sentence) == bool(found)
        assert sentence in unescape(page.read_text(encoding="utf-8"))


def test_a_recording_recovered_from_altered_samples_is_not_taken_for_verified(intact: Path, flipped: Path, tmp_path: Path) -> None:
    new = tmp_path / "new"
    recover(flipped, new)
    assert Recording(new).digests().match is True
    sentence = recovered(Recording(new).stored)
    assert sentence.startswith(f"recovered from flipped; lost: {SENTENCE}")
    assert json.loads(dcrb("info", str(new), "--json").stdout)["recovered"] == sentence
    assert sentence in dcrb("info", str(new)).stdout
    done = dcrb("detect", str(new), "--json", "--report", str(tmp_path / "page.html"))
    assert json.loads(done.stdout)["recovered"] == sentence
    assert done.stderr.count(f"note: {new}: {sentence}") == 1
    assert sentence in unescape((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert recovered(Recording(intact).stored) == ""


def test_many_losses_are_counted_and_a_damaged_record_of_them_is_named(tmp_path: Path) -> None:
    for text, sentence in (
        (
            json.dumps({"source": "bag", "lost": [f"part {number}" for number in range(7)]}),
            "bag; lost: part 0; part 1; part 2; part 3; part 4; 2 more",
        ),
        (json.dumps({"source": "bag", "lost": []}), "bag; lost: nothing"),
        ("{", "an unknown recording; lost: the record dcrb_ros_recovery is damaged"),
    ):
        path = tmp_path / f"{len(text)}"
        bag = Bag(path, opening={}, closing=lambda text=text: {RECOVERY: {"recovery": text}})
        bag.write([(channel_of(VIBRATION, NAMESPACE), 0, b"")])
        bag.close()
        assert recovered(valid_files(path)[0]) == f"recovered from {sentence}"
