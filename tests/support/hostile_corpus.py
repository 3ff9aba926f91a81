"""Hostile inputs, made in code: what each is, the commands that it is fed to, and what they answer."""

from __future__ import annotations

import io
import json
import os
import struct
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import zstandard
from made_up_blocks import BODIES, FREQUENCIES, recorded
from mcap.writer import Writer

from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.points import encode_vibration
from dcrb_ros.messages.statuses import encode_truth
from dcrb_ros.messages.topics import GROUND_TRUTH, MANIFEST, VIBRATION
from dcrb_ros.recordings.manifest import DIGEST, OUTCOME, opening
from dcrb_ros.recordings.mcap_reader import MAGIC
from dcrb_ros.recordings.mcap_writer import Channel
from dcrb_ros.recordings.recorder import channel_of
from dcrb_ros.recordings.splitting import Bag
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.stream.block import Block, Truth

INPUT, NEW = "INPUT", "NEW"
"""Placeholders for the hostile input and for a new path."""
MEGABYTE = 1_000_000
CONFIGURATION = (("config", "check", INPUT), ("simulate", INPUT, "-o", NEW))
YAML = (
    *CONFIGURATION,
    ("detect", "GOOD", "--detector", INPUT),
    ("import", "WAVE", "--about", INPUT, "-o", NEW),
    ("simulate", "dry", "--scenario", INPUT, "-o", NEW),
    ("score", INPUT, "--list"),
    ("sweep", INPUT, "--dry-run"),
)
"""Every command that reads YAML."""
BAG = (
    ("info", INPUT),
    ("detect", INPUT),
    ("export", INPUT, "-o", f"{NEW}.npz"),
    ("recover", INPUT, "-o", NEW),
    ("view", INPUT, "--save", f"{NEW}.rrd"),
    ("plot", INPUT, "-o", f"{NEW}.png"),
    ("score", INPUT),
    ("simulate", "--from", INPUT),
)
"""Every command that reads a recording."""
SCENARIO = (("simulate", "dry", "--scenario", INPUT, "-o", NEW),)
EXAM = (("score", INPUT, "--list"),)
SWEEP = (("sweep", INPUT, "--dry-run"),)
LIVE = (("@sensor", INPUT),)


@dataclass(frozen=True)
class Case:
    """A hostile input."""

    make: Callable[[Path], object]
    """Makes it at a path."""
    commands: tuple[tuple[str, ...], ...]
    words: str = ""
    """What at least one of the commands answers."""
    suffix: str = ".yaml"
    statuses: tuple[int, ...] = (2,)
    """Exit statuses that are right."""
    quick: bool = True
    """Whether the case is part of `make test`; `make hostile` runs all."""
    most_output: int = 100_000
    """Largest answer [characters]."""


def text(content: str | bytes) -> Callable[[Path], object]:
    """Return a factory of a file."""
    return lambda path: path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8", "surrogatepass"))


def empty(size: int) -> Callable[[Path], object]:
    """Return a factory of a file of zeros that takes no room on the disk."""

    def make(path: Path) -> None:
        with path.open("wb") as stream:
            stream.truncate(size)

    return make


def doublings(levels: int) -> str:
    """Return YAML whose aliases expand to two to the power of ``levels`` values."""
    return "a0: &x0 [1]\n" + "".join(f"a{k}: &x{k} [*x{k - 1}, *x{k - 1}]\n" for k in range(1, levels))


def scenario(*entries: dict[str, Any]) -> Callable[[Path], object]:
    """Return a factory of a scenario."""
    return text(json.dumps({"timeline": entries}))


def exam(**changes: Any) -> Callable[[Path], object]:
    """Return a factory of an exam."""
    entry = {"name": "a", "verdict": "outer_ring", "fault": {"faults.outer_1.width": 0.002}, **changes.pop("entry", {})}
    return text(json.dumps({"exam": "x", "scenarios": [entry], **changes}))


def sweep(**changes: Any) -> Callable[[Path], object]:
    """Return a factory of a sweep."""
    return text(json.dumps({"duration": 1.0, **changes}))


def description(**changes: Any) -> Callable[[Path], object]:
    """Return a factory of a live sensor description."""
    orders = {"FTF": 0.42, "BPFO": 6.7, "BPFI": 9.3, "BSF": 3.1, **changes.pop("orders", {})}
    return text(json.dumps({"sampling_rate": 51200, "orders": orders, **changes}))


def manifest(**changes: Any) -> dict[str, Any]:
    """Return the manifest of a bench with some keys changed, without a digest, as that of an earlier version."""
    about = json.loads(opening(Configuration(), BODIES, "/dcrb")[MANIFEST]["manifest"])
    return {key: value for key, value in about.items() if key != DIGEST} | changes


def bag(
    path: Path,
    *,
    about: str = "",
    outcome: str = "",
    messages: Iterator[tuple[Channel, int, bytes]] | tuple[tuple[Channel, int, bytes], ...] = (),
) -> None:
    """Write a recording with any manifest, outcome and messages."""
    ending = {OUTCOME: {"outcome": outcome}} if outcome else {}
    written = Bag(path, opening={MANIFEST: {"manifest": about or json.dumps(manifest())}}, closing=lambda: ending)
    written.write(messages)
    written.close()


def waves(count: int, channel: Channel | None = None) -> Iterator[tuple[Channel, int, bytes]]:
    """Yield blocks of a constant waveform."""
    zeros = np.zeros((1024, 2), np.float32)
    for number in range(count):
        block = Block(1024 * number, 51200, zeros, zeros[:, 0], zeros)
        yield channel or channel_of(VIBRATION, "/dcrb"), block.stamp_ns, encode_vibration(block, zeros)


def truth(event: str) -> bytes:
    """Return a ground truth with the text of an event."""
    from dcrb_ros.stream.events import UnknownCommand

    return encode_truth(Truth(0, 125.0, (0.0, -1e5), FREQUENCIES, {}, UnknownCommand(event)))


def unpacking_to(size: int) -> Callable[[Path], object]:
    """Return a factory of a small recording whose chunks unpack to a waveform of ``size`` [bytes]."""

    def make(path: Path) -> None:
        zeros = np.zeros((1 << 18, 2), np.float32)
        wave = encode_vibration(Block(0, 51200, zeros, zeros[:, 0], zeros), zeros)
        begin = (len(wave) - 16 * len(zeros) - 1) // 4 * 4
        wave = wave[:begin] + bytes(16 * len(zeros)) + wave[begin + 16 * len(zeros) :]
        message = struct.pack("<BQHIQQ", 5, 22 + len(wave), 1, 0, 0, 0) + wave
        packed = zstandard.ZstdCompressor(level=19).compress(message)
        chunk = struct.pack("<QQQII", 0, 0, len(message), 0, 4) + b"zstd" + struct.pack("<Q", len(packed)) + packed
        stream = io.BytesIO()
        writer, channel = Writer(stream), channel_of(VIBRATION, "/dcrb")
        writer.start()
        writer.add_metadata(MANIFEST, {"manifest": json.dumps(manifest())})
        schema = writer.register_schema(channel.type, "ros2msg", channel.definition.encode())
        writer.register_channel(channel.name, "cdr", schema, {})
        writer.finish()
        head = _records(stream.getvalue(), (1, 12, 3, 4))
        path.write_bytes(MAGIC + head + (struct.pack("<BQ", 6, len(chunk)) + chunk) * (size // len(message)))

    return make


def _records(data: bytes, opcodes: tuple[int, ...]) -> bytes:
    """Return the records of some kinds of an MCAP file, each kind once, and those in its chunks."""
    found: dict[int, bytes] = {}
    at = len(MAGIC)
    while at + 9 <= len(data):
        opcode, length = struct.unpack_from("<BQ", data, at)
        found.setdefault(opcode, data[at : at + 9 + length])
        at += 9 + length
    return b"".join(found[opcode] for opcode in opcodes if opcode in found)


def packed_zeros(path: Path) -> None:
    """Write an .npz file of 8 MB that unpacks to 8 GB."""
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (1 << 27,)})
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("de.npy", "w", force_zip64=True) as stream:
        stream.write(head.getvalue())
        for _ in range(1 << 6):
            stream.write(bytes(1 << 24))


def beside(path: Path, content: Callable[[Path], object]) -> None:
    """Write a sound recording with another metadata.yaml."""
    recorded(path, 3)
    (path / "metadata.yaml").unlink()
    content(path / "metadata.yaml")


def named(topic: str) -> Callable[[Path], object]:
    """Return a factory of a recording with a topic of any name."""
    channel = Channel(topic, "std_msgs/msg/String", "string data", "[]", "")
    return lambda path: bag(path, messages=((channel, 0, encode_text("x")),))


GROWTHS = [
    {"at": 0.0, "over": 1e6, "set": {f"faults.{kind}_{number}.{what}": 0.001}}
    for kind in ("outer", "inner")
    for number in (1, 2)
    for what in ("width", "depth")
]
PIPES: dict[str, Callable[[Path], object]] = {
    "a named pipe": os.mkfifo,
    "/dev/zero": lambda path: path.symlink_to("/dev/zero"),
    "a folder": Path.mkdir,
}
BOMB = {"alias": doublings(40), "chain": "- &a0 []\n" + "".join(f"- &a{k} [*a{k - 1}]\n" for k in range(1, 30_000)), "cycle": "&a [*a]"}
CASES: dict[str, Case] = {
    **{f"{kind} as YAML": Case(make, YAML, "" if kind == "a folder" else "is a") for kind, make in PIPES.items()},
    **{f"{kind} as recording": Case(make, BAG, "mcap" if kind == "a folder" else "is a", "") for kind, make in PIPES.items()},
    "a pipe as waveform": Case(os.mkfifo, (("import", INPUT, "--about", "ABOUT", "-o", NEW),), "is a named pipe", ".csv"),
    "a pipe in a recording": Case(lambda path: (path.mkdir(), os.mkfifo(path / "a_0.mcap")), BAG, "it is a named pipe", ""),
    "a pipe beside a recording": Case(
        lambda path: os.mkfifo(recorded(path, 3) / "a_0.mcap"),
        (("info", INPUT),),
        "left out, not an MCAP file: it is a named pipe",
        "",
        (0,),
    ),
    "a pipe as metadata": Case(lambda path: beside(path, os.mkfifo), (("info", INPUT),), "metadata.yaml is a named pipe", "", (0,)),
    "60 MB of YAML": Case(empty(60 * MEGABYTE), YAML, "60000000 bytes; at most 1000000"),
    "binary": Case(text(b"\x89MCAP\xff\xfe" * 100), YAML, "byte 0 is not UTF-8"),
    "1 MB of brackets": Case(text("[" * MEGABYTE), YAML, "more than 100 levels"),
    "300000 values": Case(text("[" + "1," * 300_000 + "]"), YAML, "more than 100000 values"),
    "1 MB of one word": Case(text(f"a: {'x' * (MEGABYTE - 3)}"), YAML),
    "1 MB of one key": Case(text(f"{'x' * (MEGABYTE - 9)}: 1"), YAML),
    "a long number": Case(text(f"a: {'9' * 900_000}"), YAML, "cannot be read as int"),
    "90000 keys": Case(text("".join(f"k{number}: 1\n" for number in range(45_000))), YAML),
    **{f"aliases: {name}": Case(text(content), YAML) for name, content in BOMB.items()},
    "objects of Python": Case(text("!!python/object/apply:os.system ['true']"), YAML, "apply:os.system' is not read"),
    "control characters": Case(text("\"\\e[2J\\a\\0[/x]\": '\\e'"), YAML, r"\x1b[2J\x07\x00[/x]"),
    "1:30 as a speed": Case(text("/**: {ros__parameters: {operating: {speed: 1:30}}}"), CONFIGURATION, "operating.speed = '1:30' rad/s"),
    "a NUL in a path": Case(exam(base="a\0b"), EXAM, r"a\x00b is not a path"),
    "a name of 300 letters": Case(exam(base="x" * 300), EXAM, "cannot be used: File name too long"),
    "9998 seeds": Case(exam(seeds=list(range(9998))), EXAM, "defines 9998 scenarios"),
    "2000 seeds": Case(exam(seeds=list(range(2000))), EXAM, "4000 scenarios", statuses=(0,), most_output=MEGABYTE),
    "a product of lists": Case(
        exam(entry={"set": {key: [1.0] * 900 for key in ("operating.speed", "operating.load", "operating.lateral_load")}}),
        EXAM,
        "defines 729000000 scenarios",
    ),
    **{
        f"a sweep of {name}": Case(made, SWEEP, words)
        for name, made, words in (
            ("10000000 points", sweep(design="random", points=10_000_000), "defines 10000000 runs; a sweep has at most 1000000"),
            ("points without end", sweep(design="latin_hypercube", points=10**200), "a sweep has at most 1000000"),
            ("seeds", sweep(seeds=2**31 - 1), "defines 2147483647 runs"),
            (
                "a product of ranges",
                sweep(vary={key: {"low": 1.0, "high": 2.0, "count": 10_000} for key in ("operating.speed", "operating.lateral_load")}),
                "defines 100000000 runs",
            ),
        )
    },
    "10000 entries": Case(
        scenario(*({"at": float(k), "set": {"operating.speed": 100.0}} for k in range(10_000))), SCENARIO, "10000 entries"
    ),
    "3000 entries with an error": Case(
        scenario(*({"at": float(k), "set": {"operating.speed": 100.0 + k % 7}} for k in range(2999)), {"at": 1e5, "set": {"x": 1}}),
        SCENARIO,
        "unknown parameter 'x'",
        quick=False,
    ),
    "growths without end": Case(scenario(*({**entry, "at": 0.0} for entry in GROWTHS)), SCENARIO, "its gradual changes take 160000 steps"),
    "999 growths": Case(
        scenario(*({"at": 1000.0 * k, "over": 900.0, "set": {"faults.outer_1.width": 1e-6 * (k + 1)}} for k in range(999))),
        SCENARIO,
        "steps of 0.05 s",
    ),
    **{
        f"{name} in a description": Case(make, LIVE, words, ".json", (0,))
        for name, make, words in (
            ("orders of 1e6", description(orders={"BPFO": 1e6}), "BPFO = 1e+06 is outside 0.01 .. 1000"),
            ("an order of 1e300", description(orders={"BPFO": 1e300}), "BPFO = 1e+300 is outside"),
            ("an order of 1e-300", description(orders={"FTF": 1e-300}), "FTF = 1e-300 is outside"),
            ("orders of 1000", description(orders={"BPFO": 1000.0, "BPFI": 1000.0}), "bins in a window, more than 1048576"),
            ("a rate of 1e12", description(sampling_rate=10**12), "gives a sampling rate of 1000000000000 Hz"),
            ("a broken rate", description(sampling_rate=0.5), "gives a sampling rate of 0.5 Hz"),
            ("NaN", text('{"sampling_rate": NaN}'), "NaN is not a finite number"),
            ("20000 brackets", text('{"orders":' + "[" * 20_000), "nested more than 100 deep"),
            ("60 MB", text("[" + "1," * 30 * MEGABYTE), "at most 100000 are read"),
        )
    },
    "8 GB in a small recording": Case(unpacking_to(8 << 30), BAG[:5], "are unpacked", ".mcap", (0, 2), quick=False),
    "1 GB in a small recording": Case(unpacking_to(1 << 30), BAG[:3], "are unpacked", ".mcap", (0, 2)),
    "a manifest of 60 MB": Case(
        lambda path: bag(path, about=json.dumps(manifest())[:-1] + ', "x": [' + "0," * 30 * MEGABYTE + "0]}"),
        (("info", INPUT), ("detect", INPUT)),
        "at most 16777216 are read",
        "",
    ),
    "a manifest of brackets": Case(
        lambda path: bag(path, about=json.dumps(manifest())[:-1] + ', "x": ' + "[" * 50_000 + "]" * 50_000 + "}"),
        BAG,
        "nested more than 100 deep",
        "",
    ),
    "a manifest of empty lists": Case(
        lambda path: bag(path, about=json.dumps(manifest())[:-1] + ', "x": [' + "[]," * 5 * MEGABYTE + "0]}"),
        (("info", INPUT),),
        "at most 1000000 are read",
        "",
    ),
    "an end at 1e15": Case(
        lambda path: bag(
            path,
            outcome=json.dumps({"first_index": 0, "samples": 9, "end_index": 10**15, "sha256": "0", "commands": []}),
            messages=waves(9),
        ),
        (("simulate", "--from", INPUT), ("info", INPUT)),
        "states 9 samples from 0 to 1000000000000000",
        "",
        (0, 2),
    ),
    **{
        f"a command of 200000 {name}": Case(
            lambda path, event=event: bag(
                path,
                outcome=json.dumps({"first_index": 0, "samples": 9, "sha256": "0", "commands": [{"time_ns": 0, "command": event}]}),
                messages=((channel_of(GROUND_TRUTH, "/dcrb"), 0, truth(event)), *waves(60)),
            ),
            (("info", INPUT), ("export", INPUT, "-o", f"{NEW}.npz"), ("score", INPUT)),
            "",
            "",
            (0, 1, 2),
        )
        for name, event in (
            ("letters", "a" * 200_000),
            ("pairs", "refused: " + "a = 1, " * 30_000 + "a"),
            ("signs", "a = " + "-" * 200_000 + "1"),
            ("quotes", "a = '" + "\\'" * 100_000),
        )
    },
    "QoS texts of 6 MB": Case(
        lambda path: bag(path, messages=waves(3, Channel("/x", "sensor_msgs/msg/PointCloud2", "", "- {a: 1}\n" * 660_000, ""))),
        (("recover", INPUT, "-o", NEW), ("info", INPUT)),
        "",
        "",
        (0, 2),
    ),
    **{
        f"metadata: {name}": Case(
            lambda path, content=content: beside(path, text("rosbag2_bagfile_information:\n  " + content.replace("\n", "\n  "))),
            (("info", INPUT),),
            "damaged: metadata.yaml",
            "",
            (0,),
        )
        for name, content in {**BOMB, "alias": doublings(60)}.items()
        if name != "cycle"
    },
    "4 MB of metadata": Case(
        lambda path: beside(path, text("- {a: 1}\n" * 440_000)), (("info", INPUT),), "more than 400000 values", "", (0,)
    ),
    **{
        f"a topic named {name}": Case(named(topic), (("info", INPUT),), words, "", (0,))
        for name, topic, words in (
            ("as markup", "/a[/bold][red]b", "/a[/bold][red]b"),
            ("with escapes", "/a\x1b]0;pwned\x07\x9b2J", r"/a\x1b]0;pwned\x07\x9b2J"),
            ("right to left", "/a\u202eb", r"/a\u202eb"),
        )
    },
    "a manifest with escapes": Case(
        lambda path: bag(path, about=json.dumps(manifest(dcrb_ros="[/x]\x1b[2J\ud800", recorded="[link=x]"))),
        (("info", INPUT),),
        r"dcrb_ros [/x]\x1b[2J\ud800",
        "",
        (0,),
    ),
    "1 GB in a small .npz": Case(packed_zeros, (("import", INPUT, "--about", "ABOUT", "-o", NEW),), "are loaded", ".npz", quick=False),
    "a line of 20 MB": Case(text("a" * 20 * MEGABYTE), (("import", INPUT, "--about", "ABOUT", "-o", NEW),), "a line of 100000", ".csv"),
}
