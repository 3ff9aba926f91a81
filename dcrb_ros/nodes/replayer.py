"""The replayer node: a recording on the topics of the simulator, indistinguishable from it for subscribers."""

from __future__ import annotations

import argparse
import sys
import time
from typing import Any

from dcrb_ros.messages.statuses import OK, WARN, Status
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, CLOCK, DIAGNOSIS
from dcrb_ros.messages.topics.vehicle import VEHICLE_DESCRIPTION, VEHICLE_DIAGNOSIS
from dcrb_ros.nodes.answers import AnsweredSource
from dcrb_ros.nodes.base import BenchNode
from dcrb_ros.nodes.clock import ClockPublisher
from dcrb_ros.nodes.engine import Engine, Progress, Sink
from dcrb_ros.nodes.gate import Gate
from dcrb_ros.nodes.pacing import MAX_LAG, Pacer
from dcrb_ros.nodes.programs import main
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.nodes.ros import own_arguments, run_node
from dcrb_ros.nodes.subscriber_wait import SubscriberWait
from dcrb_ros.recordings.replay import Replay, ReplayParameters
from dcrb_ros.settings.files import flatten, validated

RUN_TIME = ("rate",)
"""Parameters that can be set while the node runs."""


class ReplayerNode(BenchNode):
    """Publishes a recording at the recorded pace, once there are subscribers."""

    purpose = "replay"

    def __init__(self, parameters: ReplayParameters | None = None) -> None:
        """Replay with ``parameters``, by default those given to the node by ROS.

        Raises:
            Refusal: the parameters are invalid, there is no such recording, or it has nothing to replay.
        """
        super().__init__("replayer")
        self._settings = self.declare(ReplayParameters, run_time=RUN_TIME, adjust=lambda given: parameters or given)
        self._replay = Replay(self._settings)
        if parameters is None:  # otherwise the command did
            self._replay.check()
        clock = [CLOCK] if self._settings.clock else []
        self._publisher = Publisher(self, [*self._replay.topics, BENCH_DIAGNOSTICS, *clock])
        self._progress, self._told = Progress(), set[str]()
        self._clocks = [ClockPublisher(self._publisher.write_messages)] if self._settings.clock else []
        gate = Gate(Pacer(self._settings.rate, time.monotonic), time.monotonic)
        sinks: list[Sink] = [*self._clocks, self._publisher, self._progress]
        diagnosis = VEHICLE_DIAGNOSIS if self._replay.latched == VEHICLE_DESCRIPTION else DIAGNOSIS
        answered = self._replay.awaited in self._replay.waveforms and diagnosis not in self._replay.topics
        self._answers = self.follow_detector(diagnosis) if answered else None
        source = AnsweredSource(self._replay, self._answers, gate) if self._answers else self._replay
        self._engine = Engine("replay", source, sinks, gate, loop=self._settings.loop)

    def start(self) -> None:
        """Publish the sensor description; wait for subscribers."""
        self._engine.prepare()
        awaited = self._replay.awaited
        self._others = self.watch_publishers(awaited, *([CLOCK] if self._settings.clock else []))
        self.repeat(1.0, self._publish_status)
        topics = awaited, self._replay.latched
        wait = SubscriberWait(self._publisher, self._settings.listeners, self._settings.wait, topics=topics)
        self.start_with_subscribers(wait, self._engine.start)

    @property
    def ended(self) -> bool:
        """Whether the whole recording has been replayed, and the detector has answered."""
        answers = None if self._engine.failure else self._answers
        return self._engine.ended and (answers is None or answers.complete(self._progress.time_ns))

    @property
    def failure(self) -> Exception | None:
        """The exception that ended the replay, if one did."""
        return self._engine.failure

    def close(self) -> None:
        """Stop; wait for the delivery of the last messages if the replay was not interrupted; warn of damage and of altered samples."""
        finished = self._engine.finished
        self._engine.close()
        if finished:
            self._repeat_clock()
            self._publisher.flush()
        self._warn_of_damage()
        if self._replay.mismatch:
            self.get_logger().warning(self._replay.mismatch)
        self._replay.close()

    def on_parameters(self, changes: dict[str, Any]) -> None:
        """Continue at another rate; refuse a change of anything else."""
        super().on_parameters({key: value for key, value in changes.items() if key not in RUN_TIME})
        self._settings = validated({**flatten(self._settings.model_dump()), **changes}, ReplayParameters, "parameters")
        self._engine.gate.rescale(self._settings.rate)

    def _repeat_clock(self) -> None:
        if self._progress.bundles:  # before the first one there is no time
            for clock in self._clocks:
                clock.repeat()

    def _warn_of_damage(self) -> None:
        """Log what of the recording cannot be read, each sentence once."""
        for sentence in self._replay.recording.damage:
            if sentence not in self._told:
                self._told.add(sentence)
                self.get_logger().warning(f"{self._replay.recording.path}: {sentence}: the readable part is replayed")

    def _publish_status(self) -> None:
        """Publish the status of the replay on /diagnostics, and the present time again on /clock."""
        self._repeat_clock()
        self._warn_of_damage()
        pacer, recording, time_ns = self._engine.gate.pacer, self._replay.recording, self._progress.time_ns
        behind, damage, others = pacer.lag > MAX_LAG, recording.damage, self._others.names
        values = {
            "bag": str(recording.path),
            "rate": f"{pacer.scale:g}",
            "recorded [s]": f"{time_ns * 1e-9:.3f}",
            "bundles": str(self._progress.bundles),
            "passes": str(self._engine.passes),
            "lag [s]": f"{pacer.lag:.4f}",
            "late_bundles": str(pacer.late),
            "damage": damage[0] if damage else "none",
            "other_publishers": ", ".join(others),
        }
        mixed = "others publish on the same topics" if others else ""
        state = "replaying" if self._engine.started else "waiting"
        message = "behind the recorded pace" if behind else mixed or (damage[0] if damage else state)
        status = Status(self.get_fully_qualified_name(), WARN if behind or mixed or damage else OK, message, values)
        self._publisher.write_messages([self.diagnostics(status, time_ns, self._replay.frame)])


def run(arguments: list[str], parameters: ReplayParameters | None = None) -> int:
    """Run the node until the recording is over or a termination signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog="replayer", description="A recording on the topics of the bench, as a ROS 2 node.")
    own_arguments(parser, arguments)
    return run_node(lambda: ReplayerNode(parameters), arguments)


if __name__ == "__main__":
    main("replayer", sys.argv[1:])
