"""DiagnosticArray messages: statuses with keys and values, among them the ground truth."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from dcrb_ros.bearing.frequencies import CHARACTERISTIC_FREQUENCIES
from dcrb_ros.messages.cdr import DIAGNOSTICS, FRAME, decoded, encoded, header, ros_type, stamp_of
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.block import Truth
from dcrb_ros.stream.event_text import decode_event, encode_event

OK, WARN, ERROR = 0, 1, 2  # diagnostic_msgs/msg/DiagnosticStatus
TIME_LAPSE = "heat is stored {:g} times as fast as in reality, and speed, load, ambient and faults keep their time"
"""Message of the status `thermal` where temperatures have a time of their own."""


@dataclass(frozen=True)
class Status:
    """One status of a DiagnosticArray."""

    name: str
    level: int
    """0 OK, 1 warning, 2 error."""
    message: str
    values: Mapping[str, str]


def encode_diagnostics(time_ns: int, statuses: Iterable[Status], frame: str = FRAME) -> bytes:
    """Return a DiagnosticArray on the bearing whose sensor has the frame id ``frame``, which also identifies the hardware."""
    pair, status_type = ros_type("diagnostic_msgs/msg/KeyValue"), ros_type("diagnostic_msgs/msg/DiagnosticStatus")
    messages = [status_type(s.level, s.name, s.message, frame, [pair(key, value) for key, value in s.values.items()]) for s in statuses]
    return encoded(DIAGNOSTICS, ros_type(DIAGNOSTICS)(header(time_ns, frame), messages))


def encode_truth(truth: Truth, frame: str = FRAME) -> bytes:
    """Return the ground truth: a status ``operating`` and one per fault, named by its configuration key."""
    operating = {"speed [rad/s]": repr(truth.speed), "load_x [N]": repr(truth.load[0]), "load_y [N]": repr(truth.load[1])}
    operating |= {f"{name} [Hz]": repr(frequency) for name, frequency in truth.frequencies.items()}
    statuses = [Status("operating", OK, encode_event(truth.event), operating)]
    if truth.background:
        statuses.append(Status("background", OK, "no fault", {key: repr(value) for key, value in truth.background.items()}))
    if truth.thermal:
        lapse = truth.thermal.get("acceleration", 1.0)
        said = TIME_LAPSE.format(lapse) if lapse > 1.0 else ""
        statuses.append(Status("thermal", OK, said, {key: repr(value) for key, value in truth.thermal.items()}))
    for name, fields in truth.faults.items():
        statuses.append(Status(f"faults.{name}", ERROR, "present", {key: repr(value) for key, value in fields.items()}))
    return encode_diagnostics(truth.time_ns, statuses, frame)


def decode_diagnostics(data: bytes) -> tuple[int, list[Status]]:
    """Return stamp [ns] and statuses of a DiagnosticArray."""
    array = decoded(data, DIAGNOSTICS)
    statuses = [Status(s.name, int(s.level), s.message, {pair.key: pair.value for pair in s.values}) for s in array.status]
    return stamp_of(array.header), statuses


def decode_truth(data: bytes) -> Truth:
    """Return the ground truth that `encode_truth` wrote.

    Raises:
        Refusal: the bytes are no such message, or a value must be a number and is not one.
    """
    time_ns, statuses = decode_diagnostics(data)
    if not statuses or statuses[0].name != "operating":
        raise Refusal("a DiagnosticArray without the status 'operating' is not a ground truth of the bench")
    operating, faults = statuses[0], [status for status in statuses if status.name.startswith("faults.")]
    background, thermal = (next((status.values for status in statuses if status.name == name), {}) for name in ("background", "thermal"))

    def number(key: str) -> float:
        return _numbers({key: operating.values.get(key, "nan")})[key]

    frequencies = {name: number(f"{name} [Hz]") for name in CHARACTERISTIC_FREQUENCIES}
    described = {s.name.removeprefix("faults."): _numbers(s.values) for s in faults}
    load = number("load_x [N]"), number("load_y [N]")
    return Truth(
        time_ns,
        number("speed [rad/s]"),
        load,
        frequencies,
        described,
        decode_event(operating.message),
        _numbers(background),
        _numbers(thermal),
    )


def _numbers(values: Mapping[str, str]) -> dict[str, float]:
    """Return values as numbers, and refuse anything else."""
    try:
        return {key: float(value) for key, value in values.items()}
    except ValueError as error:
        raise Refusal(f"a value of the ground truth is not a number ({error}): the message is damaged, record the run again") from None
