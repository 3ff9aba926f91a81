"""Recordings without a manifest, such as those of `ros2 bag record`: their manifest follows from the latched description of the sensor."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from heapq import heappop, heappush
from pathlib import Path
from typing import Any

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.messages.cdr import check_header
from dcrb_ros.messages.description import decode_sensor
from dcrb_ros.messages.plain import decode_text
from dcrb_ros.messages.topics import SENSOR, VIBRATION, Message
from dcrb_ros.recordings.manifest import MEASURED_UNITS
from dcrb_ros.recordings.storage import StoredFile
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.json import parsed_json

ENDING = f"/{SENSOR.name}"
"""End of the topic of the description in any namespace."""
WINDOW_NS = 1_000_000_000
"""Signal in which messages are put in order [ns]."""
RESET_NS = 5_000_000_000
"""Step back in time that is a reset of the simulation [ns]; to the start of a run, `WINDOW_NS` is enough."""
MOST_LATE = 25
"""Blocks of the waveform in a row that may be more than `WINDOW_NS` late [-]; more of them are of a later run."""
MAX_WAITING = 10_000
"""Messages that are held back at most; the bench sends some 500 in `WINDOW_NS`."""


class _Descriptions:
    """The topics of descriptions in all namespaces; collects those in a file."""

    def __init__(self) -> None:
        self.found: set[str] = set()

    def __contains__(self, topic: object) -> bool:
        if not str(topic).endswith(ENDING):
            return False
        self.found.add(str(topic))
        return True


def described_manifest(path: Path, files: Sequence[StoredFile]) -> dict[str, Any]:
    """Return the entries of a manifest that follow from the first description of the sensor in a recording.

    Raises:
        Refusal: there is none, it is invalid, or there are those of several benches.
    """
    topics, damage = _Descriptions(), list[str]()
    first = next((message for file in files for message in file.messages(damage, topics)), None)
    if first is None:
        raise Refusal(
            f"{path} has no manifest of the bench and no message on {SENSOR.name}: give a recording made by dcrb simulate, dcrb bench, "
            "dcrb import, or ros2 bag record -a beside a running bench; dcrb recover repairs the container of any other"
            + (f" (not all of it could be read: {damage[0]})" if damage else "")
        )
    if len(topics.found) > 1:
        raise Refusal(f"{path} contains several benches, {', '.join(sorted(topics.found))}: record the topics of one of them")
    topic, data = first.channel.topic, first.message.data
    try:
        rate, orders = decode_sensor(data)
    except Refusal as refusal:
        raise Refusal(f"{path} has no manifest of the bench, and {topic} cannot take its place: {refusal}") from None
    return {
        "described_by": topic,
        "namespace": topic.removesuffix(ENDING) or "/",
        "sampling_rate": rate,
        "orders": orders.as_dict(),
        "sensor": parsed_json(decode_text(data), str(topic)),
        "units": MEASURED_UNITS,
    }


def of_one_bench(messages: Iterable[Message], path: Path, rate: int, orders: Orders) -> Iterator[Message]:
    """Yield messages as long as the descriptions among them have the sampling rate [Hz] and the orders of the first.

    Raises:
        Refusal: another bench was started while the recording was made, so its samples have another meaning.
    """
    for message in messages:
        if message.topic == SENSOR:
            described = rate, orders
            with suppress(Refusal):  # an invalid description describes nothing
                described = decode_sensor(message.data)
            if described != (rate, orders):
                between = f"{_bench(rate, orders)}, and {_bench(*described)}"
                raise Refusal(f"{path} contains two benches one after the other, {between}: record them separately")
        yield message


def _bench(rate: int, orders: Orders) -> str:
    return f"{rate} Hz with " + ", ".join(f"{name} {order:g}" for name, order in orders.as_dict().items())


def in_order(messages: Iterable[Message]) -> Iterator[Message]:
    """Yield messages with the times of their headers, in the order of these times.

    They are recorded in the order of arrival, and several threads that compress them exchange neighbours. Messages that are more than
    `WINDOW_NS` late stay late, and those of a simulation that was reset follow the ones before. The description has no header and gets the
    time of the message before it.
    """
    waiting: list[tuple[int, int, Message]] = []
    newest = time_ns = 0
    for number, message in enumerate(messages):
        if message.topic != SENSOR:
            time_ns = header_time(message)
        if begins_again(time_ns, newest):
            yield from (heappop(waiting)[-1] for _ in range(len(waiting)))
            newest = 0
        heappush(waiting, (time_ns, number, Message(message.topic, time_ns, message.data)))
        newest = max(newest, time_ns)
        while waiting and (waiting[0][0] < newest - WINDOW_NS or len(waiting) > MAX_WAITING):
            yield heappop(waiting)[-1]
    yield from (heappop(waiting)[-1] for _ in range(len(waiting)))


def of_one_run(messages: Iterable[Message], path: Path) -> Iterator[Message]:
    """Yield messages as long as their blocks of the waveform are of one run; blocks may be late.

    Raises:
        Refusal: the simulation was reset while the recording was made, so the samples of both runs have the same times.
    """
    newest_ns, late = 0, list[int]()
    for message in messages:
        if message.topic == VIBRATION:
            if message.time_ns < newest_ns - WINDOW_NS:
                late.append(message.time_ns)
            else:
                late.clear()
            if begins_again(message.time_ns, newest_ns) or len(late) > MOST_LATE:
                raise Refusal(
                    f"{path} contains two runs one after the other: after the block at {newest_ns * 1e-9:.3f} s, the time continues at "
                    f"{late[0] * 1e-9:.3f} s; record them separately"
                )
            newest_ns = max(newest_ns, message.time_ns)
        yield message


def begins_again(time_ns: int, newest_ns: int) -> bool:
    """Return whether a message is of a later run than one with the newest stamp [ns]."""
    return time_ns < newest_ns - (RESET_NS if time_ns else WINDOW_NS)


def header_time(message: Message) -> int:
    """Return the stamp of a message with a header [ns].

    Raises:
        Refusal: it is too short.
    """
    check_header(message.data, f"on {message.topic.name} is not a valid {message.topic.type}")
    seconds, nanoseconds = struct.unpack_from("<iI" if message.data[1] & 1 else ">iI", message.data, 4)
    return int(seconds) * 1_000_000_000 + int(nanoseconds)
