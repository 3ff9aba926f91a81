"""Hostile files: whatever they claim, memory stays bounded and the answer is a sentence."""

from __future__ import annotations

import json
import re
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_blocks import BODIES, recorded
from separate_process import dcrb

from dcrb_ros.recordings.mcap_reader import MAGIC, McapRecords
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.verification import metadata_flaw
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration

pytestmark = pytest.mark.slow

HEADER = struct.pack("<BQII", 1, 8, 0, 0)
BOMB = 1 << 31


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("bags") / "bag", 30)


def chunk(compression: bytes, size: int, data: bytes, claimed: int | None = None) -> bytes:
    body = struct.pack("<QQQII", 0, 0, size, 0, len(compression)) + compression
    body += struct.pack("<Q", len(data) if claimed is None else claimed) + data
    return struct.pack("<BQ", 6, len(body)) + body


def zstd_bomb() -> bytes:
    packer = zstandard.ZstdCompressor().compressobj(size=BOMB)
    return b"".join(packer.compress(bytes(1 << 24)) for _ in range(BOMB >> 24)) + packer.flush()


HOSTILE = {
    "zstd bomb": lambda: chunk(b"zstd", 1000, zstd_bomb()),
    "zstd bomb that says so": lambda: chunk(b"zstd", BOMB, zstd_bomb()),
    "lz4 bomb": lambda: chunk(b"lz4", 1000, lz4.frame.compress(bytes(1 << 28))),
    "a chunk of more than there is": lambda: chunk(b"", 1 << 62, b"abc"),
    "data of more than there is": lambda: chunk(b"", 3, b"abc", claimed=1 << 62),
    "a record without end": lambda: struct.pack("<BQ", 12, 1 << 62) + b"abc",
    "metadata of endless text": lambda: struct.pack("<BQI", 12, 4, 0xFFFFFFFF),
    "an unknown packer": lambda: chunk(b"xz", 3, b"abc"),
    "a message without head": lambda: struct.pack("<BQ", 5, 3) + b"abc",
    "zeros": lambda: bytes(100000),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_records_are_remarked_in_bounded_memory(name: str, tmp_path: Path) -> None:
    path = tmp_path / "hostile.mcap"
    path.write_bytes(MAGIC + HEADER + HOSTILE[name]())
    code = (
        "import resource, sys\n"
        "from pathlib import Path\n"
        "from dcrb_ros.recordings.mcap_reader import McapRecords\n"
        "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "records = McapRecords(Path(sys.argv[1])); list(records)\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before, len(records.damage))\n"
    )
    done = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, timeout=400, check=False)
    assert done.returncode == 0, done.stderr
    grown, damage = map(int, done.stdout.split())
    assert grown < 150_000  # [KiB]
    assert damage >= 1


@pytest.mark.parametrize("name", ["zstd bomb that says so", "a record without end", "zeros"])
def test_every_command_answers_a_hostile_recording_in_a_sentence(name: str, bag: Path, tmp_path: Path) -> None:
    whole = (bag / "bag_0.mcap").read_bytes()
    path = tmp_path / "hostile.mcap"
    path.write_bytes(whole[:9000] + HOSTILE[name]())
    for command in (["info", str(path)], ["recover", str(path), "-o", str(tmp_path / "new")]):
        done = dcrb(*command)
        assert done.returncode in (0, 2), done.stderr
        assert "Traceback" not in done.stderr


def test_each_of_many_flipped_bytes_is_survived(bag: Path, tmp_path: Path) -> None:
    whole = (bag / "bag_0.mcap").read_bytes()
    path, random = tmp_path / "flipped.mcap", np.random.default_rng(4)
    head_and_tail = [*range(0, 3000, 7), *range(len(whole) - 3000, len(whole), 7)]
    for at in [*head_and_tail, *random.integers(0, len(whole), 100)]:
        broken = bytearray(whole)
        broken[at] ^= 0xFF
        path.write_bytes(broken)
        try:
            recording = Recording(path)
            counts = recording.counts()
            recording.commands()
        except Refusal as refusal:
            assert "\n" not in str(refusal)  # noqa: PT017 - a refusal is one of the two right answers
        else:
            assert counts.get("/dcrb/outer_ring/vibration", 0) <= 30


@given(st.binary(max_size=400), st.integers(0, 2**32), st.integers(0, 3000))
@settings(max_examples=200)
def test_any_bytes_anywhere_are_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, bag: Path, content: bytes, seed: int, cut: int
) -> None:
    whole = (bag / "bag_0.mcap").read_bytes()
    at = int(np.random.default_rng(seed).integers(0, len(whole)))
    path = tmp_path_factory.mktemp("fuzz") / "x.mcap"
    path.write_bytes(whole[:at] + content + whole[at + cut :])
    try:
        sum(Recording(path).counts().values())
    except Refusal as refusal:
        assert "\n" not in str(refusal)  # noqa: PT017 - a refusal is one of the two right answers
    path.write_bytes(MAGIC + content)
    assert len(list(McapRecords(path))) <= len(content)


@pytest.mark.parametrize(
    "text",
    ["", "[", "{}", "rosbag2_bagfile_information: 3", "rosbag2_bagfile_information: {relative_file_paths: 7}", "[" * 5000, "\x00", "é" * 9],
)
def test_damaged_metadata_is_named_and_the_recording_read(text: str, tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 3)
    (bag / "metadata.yaml").write_text(text, encoding="latin-1")
    assert re.fullmatch("metadata.yaml is (damaged: it must have|not valid YAML|not a text file).*", metadata_flaw(bag))
    assert sum(1 for _ in Recording(bag).vibrations()) == 3


@given(st.binary(max_size=300))
def test_any_metadata_is_survived(tmp_path_factory: pytest.TempPathFactory, bag: Path, content: bytes) -> None:
    folder = tmp_path_factory.mktemp("metadata")
    (folder / "bag_0.mcap").write_bytes((bag / "bag_0.mcap").read_bytes()[:100])
    (folder / "metadata.yaml").write_bytes(content)
    assert "\n" not in metadata_flaw(folder)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@given(
    st.sampled_from(
        [
            "format",
            "units",
            "software",
            "orders",
            "configuration",
            "sampling_rate",
            "namespace",
            "imported",
            "sensor",
            "samples",
            "sha256",
            "commands",
        ]
    ),
    JSON,
)
@settings(max_examples=100)
def test_any_manifest_is_explained_or_refused(tmp_path_factory: pytest.TempPathFactory, key: str, value: object) -> None:
    from dcrb_ros.cli.info import info
    from dcrb_ros.messages.topics import MANIFEST
    from dcrb_ros.recordings.manifest import OUTCOME, opening
    from dcrb_ros.recordings.reproduction import recorded_samples
    from dcrb_ros.recordings.splitting import Bag

    about = json.loads(opening(Configuration(), BODIES, "/dcrb")[MANIFEST]["manifest"])
    outcome = {"samples": 3, "sha256": "0", "first_index": 0, "commands": []}
    (outcome if key in outcome else about)[key] = value
    folder = tmp_path_factory.mktemp("manifest") / "bag"
    ending = {OUTCOME: {"outcome": json.dumps(outcome)}}
    Bag(folder, opening={MANIFEST: {"manifest": json.dumps(about)}}, closing=lambda: ending).close()
    try:
        info(folder)
        recorded_samples(Recording(folder))
    except Refusal as refusal:
        assert "\n" not in str(refusal)  # noqa: PT017 - a refusal is one of the two right answers


def test_a_wrong_checksum_is_damage(tmp_path: Path) -> None:
    body = struct.pack("<QQQII", 0, 0, 3, zlib.crc32(b"abd"), 0) + struct.pack("<Q", 3) + b"abc"
    path = tmp_path / "x.mcap"
    path.write_bytes(MAGIC + HEADER + struct.pack("<BQ", 6, len(body)) + body)
    records = McapRecords(path)
    assert len(list(records)) == 1
    assert any("the checksum of a chunk does not match" in words for words in records.damage)
