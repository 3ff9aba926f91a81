"""The fault detector node: subscribes to the waveform and the temperatures, publishes diagnoses."""

from __future__ import annotations

import argparse
import sys

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.topics import DIAGNOSIS
from dcrb_ros.nodes.base import BenchNode
from dcrb_ros.nodes.detector_topics import DetectorTopics
from dcrb_ros.nodes.managed_detector import ManagedDetectorNode
from dcrb_ros.nodes.programs import main
from dcrb_ros.nodes.ros import own_arguments, run_node


class FaultDetectorNode(BenchNode):
    """A detector that works from its start to its end."""

    def __init__(self, parameters: DetectorParameters | None = None) -> None:
        """Subscribe, with ``parameters``, by default those given to the node by ROS.

        Raises:
            Refusal: the parameters are invalid.
        """
        super().__init__("fault_detector")
        self.watch_publishers(DIAGNOSIS)
        DetectorTopics(self, self.declare(DetectorParameters, adjust=lambda given: parameters or given)).subscribe()


def run(arguments: list[str], parameters: DetectorParameters | None = None) -> int:
    """Run the node until a termination signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog="fault_detector", description="The fault detector as a ROS 2 node.")
    parser.add_argument("--managed", action="store_true", help="wait as a lifecycle node for the transitions configure and activate")
    managed = own_arguments(parser, arguments).managed
    return run_node(ManagedDetectorNode if managed else lambda: FaultDetectorNode(parameters), arguments)


if __name__ == "__main__":
    main("fault_detector", sys.argv[1:])
