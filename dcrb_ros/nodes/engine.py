"""The engine of the simulator and the replayer: a thread that passes bundles of messages from a source to its sinks. No ROS."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import closing
from functools import partial
from typing import Protocol

from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.topics import Message
from dcrb_ros.nodes.gate import Gate
from dcrb_ros.runtime.threads import NamedThread
from dcrb_ros.stream.states import LubricationState, ThermalState

CLOSE_TIMEOUT = 0.7
"""Wall time in which the present bundle must be finished when the node ends [s]; a compilation takes longer and is abandoned."""


class BundleSource(Protocol):
    """Produces bundles of messages."""

    def start(self) -> Sequence[Message]:
        """Go to the start; return the messages that precede the first bundle."""

    def bundles(self) -> Generator[Bundle, None, None]:
        """Yield the bundles from the start in the order of time."""


class Sink(Protocol):
    """Receives the messages of a source, called by the engine's thread."""

    def start(self, messages: Sequence[Message]) -> None:
        """Take the messages that precede the first bundle; called before the first bundle and after every reset."""

    def write(self, bundle: Bundle) -> None:
        """Take the messages of a bundle at the time at which they are due."""


class Progress:
    """A sink that counts."""

    def __init__(self) -> None:
        self.time_ns = 0
        """End of the last bundle [ns]."""
        self.bundles = 0
        """Bundles since the start or the last reset."""
        self.energy_residual: float | None = None
        """Residual of the energy balance in the last block that has one [J]; None before it, and for a vehicle."""
        self.lubrication: LubricationState | None = None
        """Films and friction in the last states; None for a dry bearing."""
        self.thermal: ThermalState | None = None
        """Temperatures in the last states; None without a thermal network."""

    def start(self, messages: Sequence[Message]) -> None:
        """Return to the values before the first bundle."""
        self.time_ns = self.bundles = 0
        self.energy_residual = self.lubrication = self.thermal = None

    def write(self, bundle: Bundle) -> None:
        """Count a bundle."""
        self.time_ns = bundle.end_ns
        self.bundles += 1
        if bundle.block is not None and bundle.block.energy is not None:
            self.energy_residual = bundle.block.energy.residual
        if bundle.block is not None and bundle.block.states:
            self.lubrication, self.thermal = bundle.block.states[-1].lubrication, bundle.block.states[-1].thermal


class Engine:
    """Passes the bundles of a source to sinks, each at its deadline, in a thread of its own.

    Pause, step, time scale and reset are controlled through `gate` from other threads.
    """

    def __init__(self, name: str, source: BundleSource, sinks: Sequence[Sink], gate: Gate, *, loop: bool = False) -> None:
        """Prepare a thread called ``name``; with ``loop`` it starts again at the end of the source."""
        self.gate = gate
        self.failure: Exception | None = None
        """The exception that ended the thread."""
        self.passes = 0
        """How many times the source has been started."""
        self.computed = False
        """Whether the source has yielded a bundle since the start or the last reset."""
        self._source, self._sinks, self._loop = source, sinks, loop
        self.prepared = False
        """Whether the source has been started."""
        self._loaded: Sequence[Message] | None = None
        """What `load` keeps for `prepare`."""
        self._thread = NamedThread(name, self._run)

    @property
    def started(self) -> bool:
        """Whether the thread has been started."""
        return self._thread.ident is not None

    @property
    def ended(self) -> bool:
        """Whether the work has ended: at the end of the source, by a failure, or because the gate was closed, even before `start`."""
        return not self._thread.is_alive() if self.started else self.gate.closed

    @property
    def finished(self) -> bool:
        """Whether the work has ended by itself, not because the gate was closed."""
        return self.ended and not self.gate.closed

    def load(self) -> None:
        """Start the source, which may take minutes, and pass nothing on yet."""
        self._loaded = self._source.start()

    def prepare(self) -> None:
        """Start the source unless `load` has, and pass the messages that precede the first bundle to the sinks; call it before `start`."""
        messages = self._source.start() if self._loaded is None else self._loaded
        self._loaded, self.prepared = None, True
        for sink in self._sinks:
            sink.start(messages)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def reset(self, timeout: float) -> bool:
        """Return to the start, before `start` in the caller's thread; return whether it is done within ``timeout`` of wall time [s]."""
        if self.started:
            return self.gate.reset(timeout)
        self.gate.pause(self.gate.paused, stopped=self.gate.stopped)  # discards requested steps
        self.prepare()
        return True

    def close(self) -> None:
        """Send nothing any more and wait for the thread, up to `CLOSE_TIMEOUT`."""
        self.gate.close()
        if self.started:
            self._thread.join(CLOSE_TIMEOUT)

    def _run(self) -> None:
        try:
            while not self.gate.closed:
                self.passes += 1
                if not self._play():
                    self._reset()
                elif self._loop:
                    self.gate.start_over()
                else:
                    return
        except Exception as error:  # any failure must reach the main thread
            self.failure = error

    def _play(self) -> bool:
        """Send the bundles; return false if a reset or the end of the program interrupts them."""
        with closing(self._source.bundles()) as bundles:
            for bundle in bundles:
                self.computed = True
                if not self.gate.send(bundle.begin_ns * 1e-9, bundle.end_ns * 1e-9, partial(self._write, bundle)):
                    return False
        return True

    def _write(self, bundle: Bundle) -> None:
        for sink in self._sinks:
            sink.write(bundle)

    def _reset(self) -> None:
        if not self.gate.closed:
            self.computed = False
            self.prepare()
            self.gate.finish_reset()
