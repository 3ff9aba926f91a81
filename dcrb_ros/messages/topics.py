"""The topics of the bench: names, types and how they are delivered."""

from __future__ import annotations

from dataclasses import dataclass

NAMESPACE = "/dcrb"
MANIFEST = "dcrb_ros"
"""Name of the metadata record by which a recording explains itself."""

POINT_CLOUD = "sensor_msgs/msg/PointCloud2"
JOINT_STATE = "sensor_msgs/msg/JointState"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"


@dataclass(frozen=True)
class Topic:
    """A topic relative to the namespace, or absolute."""

    name: str
    type: str
    depth: int = 200
    """Messages kept for a slow reader; for blocks several seconds of them."""
    latched: bool = False
    """Whether a late reader gets the last message."""

    def resolved(self, namespace: str) -> str:
        """Return the absolute name."""
        return self.name if self.name.startswith("/") else f"{namespace.rstrip('/')}/{self.name}"


@dataclass(frozen=True)
class Message:
    """A message on its way: encoded once, published and recorded as the same bytes."""

    topic: Topic
    time_ns: int
    """Simulated time of the header [ns]."""
    data: bytes
    """The message in CDR."""


VIBRATION = Topic("outer_ring/vibration", POINT_CLOUD)
VIBRATION_CLEAN = Topic("outer_ring/vibration_clean", POINT_CLOUD)
SENSOR = Topic("outer_ring/sensor", "std_msgs/msg/String", depth=1, latched=True)
ACCELERATION = Topic("outer_ring/acceleration", "sensor_msgs/msg/Imu", depth=500)
FEATURES = Topic("outer_ring/features", JOINT_STATE)
ROLLER_STATES = Topic("roller_states", JOINT_STATE, depth=500)
ROLLER_CONTACTS = Topic("roller_contacts", JOINT_STATE, depth=500)
GROUND_TRUTH = Topic("ground_truth", DIAGNOSTICS)
DIAGNOSIS = Topic("diagnosis", DIAGNOSTICS)
FAULT_INDICATORS = Topic("fault_indicators", JOINT_STATE)
ENVELOPE_SPECTRUM = Topic("envelope_spectrum", POINT_CLOUD)
BENCH_DIAGNOSTICS = Topic("/diagnostics", DIAGNOSTICS)
CLOCK = Topic("/clock", "rosgraph_msgs/msg/Clock", depth=10)

SIMULATED = (VIBRATION, VIBRATION_CLEAN, SENSOR, ACCELERATION, FEATURES, ROLLER_STATES, ROLLER_CONTACTS, GROUND_TRUTH)
"""What the simulator publishes and records."""
DETECTED = (DIAGNOSIS, FAULT_INDICATORS, ENVELOPE_SPECTRUM)
"""What the fault detector publishes."""
