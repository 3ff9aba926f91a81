"""The view of a running vehicle: messages are logged to Rerun as they arrive, in batches of some tenths of a second."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable

import rerun as rr

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.messages.cdr import STAMP_END, stamps
from dcrb_ros.messages.topics import VIBRATION, Topic
from dcrb_ros.messages.topics.vehicle import VEHICLE_DESCRIPTION
from dcrb_ros.messages.vehicle import decode_description
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.viewer.content import TimedWaveform, joined
from dcrb_ros.viewer.live_run import LONGEST_FLUSH, ReceivedMessages, as_current
from dcrb_ros.viewer.spectrum import envelope_spectra
from dcrb_ros.viewer.spectrum_picture import GrowingSpectra
from dcrb_ros.viewer.vehicle_blueprint import SPECTRA, compose
from dcrb_ros.viewer.vehicle_content import PARTS, VehicleContent, content_of
from dcrb_ros.viewer.vehicle_document import largest_level, log_vehicle

KEPT = 3.0
"""Signal that is kept to align the next blocks [s]; a wheelbase of 2.6 m takes 1.9 s at 5 km/h."""


class VehicleLiveView(ReceivedMessages):
    """Logs the messages of a running vehicle to Rerun; see `ReceivedMessages`."""

    def __init__(self, begin: Callable[[int], rr.RecordingStream], title: str, log: Callable[[str], object]) -> None:
        """Log to the streams that ``begin`` returns; see `ReceivedMessages`."""
        super().__init__(begin, title, log)
        self._description: VehicleDescription | None = None
        self._stream: rr.RecordingStream | None = None
        self._recent: dict[str, TimedWaveform] = {}
        self._spectra: dict[str, GrowingSpectra] = {}
        self._largest = 0.0
        self._verdicts: dict[str, str] = {}
        """The verdicts logged last, by the names of the parts of the vehicle."""

    @property
    def description(self) -> VehicleDescription | None:
        """The vehicle that is shown; None before its description has arrived."""
        return self._description

    def take(self, topic: Topic, data: bytes) -> None:
        """Keep a message until the next `flush`."""
        if topic != VEHICLE_DESCRIPTION:
            if self._description is not None and topic == VIBRATION.below(self._description.boxes[0].name) and len(data) >= STAMP_END:
                self._check_time(int(stamps([data])[0]))
            self._keep(topic, data)
            return
        try:
            description = decode_description(data)
        except Refusal as refusal:
            self._refuse(refusal)
            return
        if description != self._description:
            self.close()
            self._description = description

    def flush(self) -> None:
        """Log the received messages, once the vehicle has been described."""
        if self._description is None:
            return
        received, self._received = self._received, defaultdict(list)
        try:
            content = content_of(received, self._description, self._title)
        except Refusal as refusal:
            self._refuse(refusal)
            return
        if not content.waveforms:
            self._received = received  # they are shown with the next part of the waveforms
            return
        self._show(content)

    def _show(self, content: VehicleContent) -> None:
        begins = self._stream is None
        if self._stream is None:
            self._stream = self._next_stream()
            self._stream.send_blueprint(compose(content, live=True))
        self._largest = max(self._largest, largest_level(content))
        with as_current(self._stream):
            log_vehicle(content, fixed=begins, before=self._recent, largest=self._largest, verdicts=self._verdicts)
            self._log_spectra(content)
        for name, waveform in content.waveforms.items():
            self._recent[name] = joined(self._recent.get(name), waveform, *PARTS, last=round(KEPT * waveform.rate))

    def _log_spectra(self, content: VehicleContent) -> None:
        for name, judgements in content.judgements.items():
            spectra = envelope_spectra(judgements)
            if spectra is not None:
                if name not in self._spectra:
                    orders = Orders.from_dict(dict(content.description.box(name).orders))
                    self._spectra[name] = GrowingSpectra(orders, root=f"{SPECTRA}/{name}")
                self._spectra[name].log(spectra)

    def _end(self) -> None:
        if self._stream is not None:
            self._stream.flush(timeout_sec=LONGEST_FLUSH)
            self._stream.disconnect()
        self._stream, self._recent, self._spectra, self._largest, self._verdicts, self._newest_ns = None, {}, {}, 0.0, {}, 0

    def close(self) -> None:
        """Log the remaining messages and close the recording."""
        self.flush()
        if self._description is not None:
            self._received.clear()  # messages after the last waveform belong to no other recording
        self._end()
