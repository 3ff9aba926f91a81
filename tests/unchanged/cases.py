"""Runs over all laws, faults, joints and sensors, and the fingerprints of what they produce.

The fingerprints in ``fingerprints.json`` were taken from the code before its rebuild (commit 62b584c); those of the three runs with
``contact.notch: edge`` are later, since edges that touch one roller share its contact. Those of ``losses`` are that commit's on
processors with AVX2; with AVX-512 they were others. Those of ``OILED_CASES`` are of commit 4e5cb25, except for runs with oil at the cages:
their lands damp more since 30 November 2026. The preview of the scenario (``outer_ring/acceleration``) has another covariance since then:
zeros for unknown.
``python tests/unchanged/cases.py`` prints the present ones; ``--write`` replaces the file, which is right only when the model was meant to
change. It needs ``tests/support`` on the path.
"""

from __future__ import annotations

import hashlib
import json
import sys
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from dry_benches import FAULTS, dry_bench

from dcrb_ros.bearing.payload import body_names
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.scenario import read_scenario
from dcrb_ros.stream.block import Block

FILE = Path(__file__).with_name("fingerprints.json")
ROOT = Path(__file__).parents[2]
SHORT = 0.06
"""Simulated time of a case [s]: three blocks."""
EVERY_TOPIC = ("publishing.clean=true", "publishing.contacts=true")
AT_THE_RING = "structure.housing=none"
"""The fingerprints are older than the housings of the shipped benches."""
THREE_FAULTS = (
    "faults.outer_2.width=0.003",
    "faults.outer_2.azimuth=0.2",
    "faults.inner_2.width=0.001",
    "faults.inner_2.azimuth=1.0",
    "faults.roller_2.width=0.002",
)

CASES: dict[str, tuple[str, tuple[str, ...]]] = {
    "healthy": ("healthy", ()),
    "paper": ("paper", ()),
    "outer_ring_defect": ("outer_ring_defect", ()),
    "inner_ring_defect": ("inner_ring_defect", ()),
    "cage_fracture": ("cage_fracture", ()),
    "compound": ("compound", ()),
    "roller_defect": ("healthy", ("faults.roller_1.width=0.002", "faults.roller_1.azimuth=0.5")),
    "six_defects": ("compound", THREE_FAULTS),
    "revolute": ("healthy", ("cage.joint=revolute",)),
    "revolute_outer_defect": ("outer_ring_defect", ("cage.joint=revolute",)),
    "revolute_roller_defect": ("healthy", ("cage.joint=revolute", "faults.roller_1.width=0.002")),
    "revolute_broken_bars": ("healthy", ("cage.joint=revolute", "faults.broken_bars=row1/bar15, row2/bar3, row2/bar4")),
    "pocket_broken_bars": ("healthy", ("faults.broken_bars=row1/bar1, row1/bar2, row2/bar16",)),
    "power_law": ("healthy", ("contact.law=power", "contact.power_exponent=1.11")),
    "power_law_revolute_defect": ("inner_ring_defect", ("contact.law=power", "cage.joint=revolute")),
    "edges": ("outer_ring_defect", ("contact.notch=edge",)),
    "edges_compound_power": ("compound", ("contact.notch=edge", "contact.edge_radius=0.0003", "contact.law=power")),
    "edges_revolute": ("inner_ring_defect", ("contact.notch=edge", "cage.joint=revolute")),
    "losses": ("healthy", ("contact.loss_time=1e-5", "contact.damping=50.0", "cage.restitution=0.3", "cage.friction_coefficient=0.12")),
    "little_friction": ("healthy", ("friction.kinetic_coefficient=0.001", "friction.static_coefficient=0.002")),
    "creep": ("healthy", ("friction.convection=0.7", "friction.viscous=0.01", "friction.stribeck_speed=0.03")),
    "single_row": ("inner_ring_defect", ("bearing.rows=1", "bearing.rollers_per_row=13")),
    "staggered": ("healthy", ("bearing.row_phase=0.5", "operating.lateral_load=20000.0")),
    "cold": ("paper", ("operating.start=cold", "operating.speed=60.0")),
    "reverse_slow_light": ("outer_ring_defect", ("operating.speed=-20.0", "operating.load=5000.0", "operating.gravity=0.0")),
    "fast_vehicle": ("healthy", ("operating.speed_kmh=200.0", "simulation.step=4.8828125e-6", "simulation.seed=7")),
    "land_and_pockets": ("healthy", ("cage.land_clearance=0.0001", "cage.pocket_clearance=0.0004", "operating.speed=300.0")),
    "iepe": ("outer_ring_defect", ("sensor.preset=iepe_100mv_g", "structure.modes=3", "simulation.seed=3")),
    "mems": (
        "healthy",
        ("sensor.preset=mems", "sensor.static_gravity=0", "sensor.sampling_rate=25600", "structure.modes=5", "structure.coupling=0.4"),
    ),
    "chain": (
        "inner_ring_defect",
        (
            "sensor.cross_axis=0.05",
            "sensor.ac_coupling=2.0",
            "sensor.bias=1.5",
            "sensor.bias_drift=0.1",
            "sensor.clock_offset_ppm=80.0",
            "sensor.clock_jitter=1e-6",
            "sensor.adc_bits=12",
            "sensor.range=200.0",
            "sensor.white_noise_ug=40.0",
            "sensor.pink_noise_ug=60.0",
            "sensor.mount_frequency=9000.0",
            "sensor.mount_damping=0.05",
            "sensor.bandwidth=10000.0",
        ),
    ),
    "background": (
        "healthy",
        (
            "background.unbalance=0.00005",
            "background.joint_level=40.0",
            "background.joint_spacing=1.0",
            "background.flat_level=30.0",
            "background.track_level=4.0",
            "background.impact_rate=60.0",
            "background.impact_level=150.0",
            "background.hum_level=2.0",
            "structure.modes=2",
        ),
    ),
    "stuck": ("outer_ring_defect", ("sensor.fault=stuck",)),
    "loose": ("outer_ring_defect", ("sensor.fault=loose", "sensor.fault_severity=0.7")),
    "saturated": ("outer_ring_defect", ("sensor.fault=saturated", "sensor.fault_axis=y")),
    "spikes": ("healthy", ("sensor.fault=spikes",)),
    "dead": ("healthy", ("sensor.fault=dead", "sensor.fault_axis=x")),
    "gain_drift": ("healthy", ("sensor.fault=gain_drift", "sensor.fault_time=0.02")),
    "bursts_and_losses": ("healthy", ("publishing.loss_probability=0.4", "publishing.burst_length=0.03", "publishing.burst_period=0.05")),
    "odd_blocks": ("outer_ring_defect", ("publishing.block_size=700", "publishing.state_rate=333", "publishing.preview_rate=100")),
}
"""Configuration, `paper` or the name of a dry bench, and settings of each run."""

FILM = ("lubrication.law=film", "lubrication.lubricant=grease", "lubrication.temperature=60.0", "operating.start=settled")
"""An oil film between smooth surfaces."""
DRY_CAGE = "lubrication.law=film"
"""A dry cage beside oiled raceways."""
OILED_CASES: dict[str, tuple[str, tuple[str, ...]]] = {
    "oiled_healthy": ("healthy", ()),
    "oiled_outer_ring_defect": ("outer_ring_defect", ()),
    "oiled_inner_ring_defect": ("inner_ring_defect", ()),
    "oiled_roller_defect": ("roller_defect", ()),
    "oiled_cage_fracture": ("cage_fracture", ()),
    "oiled_compound": ("compound", ()),
    "oiled_chain": ("outer_ring_defect", ("sensor.preset=iepe_100mv_g", "structure.modes=3", "background.track_level=4.0")),
    "oiled_dent": ("healthy", ("faults.outer_1.kind=dent", "faults.outer_1.width=0.002", "faults.outer_1.depth=2e-5")),
    "oiled_fluting": ("healthy", ("faults.inner_1.kind=fluting", "faults.inner_1.width=0.02")),
    "film": ("dry", FILM),
    "film_revolute": ("dry", (*FILM, "cage.joint=revolute")),
    "film_notch": ("dry", (*FILM, "faults.outer_1.width=0.002")),
    "smooth_film_with_cages": ("healthy", ("surfaces.law=smooth",)),
    "profiled_dry": ("dry", ("surfaces.law=profile", "surfaces.seed=3")),
    "profiled_dry_defect": ("dry", ("surfaces.law=profile", "faults.inner_1.kind=spall", "faults.inner_1.width=0.002")),
    "thermal": ("healthy", ("thermal.law=network", "thermal.acceleration=200.0")),
    "thermal_faults": (
        "healthy",
        (
            "thermal.law=network",
            "faults.lubrication.loss=0.8",
            "faults.seal_rub.torque=2.0",
            "faults.clearance.lost=5e-5",
        ),
    ),
    "balls": ("ball_bearing_6205", (DRY_CAGE,)),
    "balls_outer": ("ball_bearing_6205", (DRY_CAGE, "faults.outer_1.width=0.0005")),
    "balls_roller": ("ball_bearing_6205", (DRY_CAGE, "faults.roller_1.width=0.0005", "simulation.seed=4")),
    "balls_oiled_cage": ("ball_bearing_6205", ()),
}
"""Shipped benches with oil, profiles, heat and balls, or the bench `dry` with one of them, and settings of each run."""

SCENARIO = """
timeline:
  - {at: 0.01, set: {operating.speed: 140.0}}
  - {at: 0.015, over: 0.02, set: {faults.outer_1.width: 0.002}}
  - {at: 0.03, set: {sensor.fault: loose}}
  - {at: 0.04, set: {sensor.fault: none, operating.load: 60000.0}}
  - {at: 0.05, set: {faults.broken_bars: row1/bar15, operating.speed_ramp: 1000.0}}
"""


def digest(parts: Iterable[bytes]) -> str:
    """Return a short hash of some bytes."""
    found = hashlib.sha256()
    for part in parts:
        found.update(part)
    return found.hexdigest()[:16]


def fingerprint(blocks: Iterable[Block], encoder: BlockEncoder) -> dict[str, str]:
    """Return a hash of the samples of a run, of its energy account, and of all messages of each topic."""
    kept = list(blocks)
    by_topic: dict[str, list[bytes]] = {}
    for message in [*encoder.start(), *(message for block in kept for message in encoder.encode(block))]:
        by_topic.setdefault(message.topic.name, []).append(message.time_ns.to_bytes(8, "little") + message.data)
    samples = (part.tobytes() for block in kept for part in (block.acceleration, block.shaft_angle, block.clean))
    energy = (repr(block.energy).encode() for block in kept)
    return {"samples": digest(samples), "energy": digest(energy), **{name: digest(parts) for name, parts in sorted(by_topic.items())}}


BY_NUMPY = frozenset(
    (
        *("oiled_outer_ring_defect", "oiled_inner_ring_defect", "oiled_roller_defect", "oiled_compound", "oiled_chain", "oiled_dent"),
        *("oiled_fluting", "profiled_dry_defect", "thermal", "thermal_faults", "balls_outer", "balls_roller"),
    )
)
"""Cases with damage on surfaces or with heat: functions of numpy, whose last bits differ between processors, enter their tables."""


def run(name: str) -> dict[str, str]:
    """Return the fingerprint of a case."""
    bench, settings = (CASES | OILED_CASES)[name]
    dry = name in CASES and bench in FAULTS
    changed = (*EVERY_TOPIC, AT_THE_RING, *settings)
    configuration = dry_bench(bench, *changed) if dry else load_configuration(bench, changed)
    return fingerprint(Simulation(configuration).blocks(SHORT), BlockEncoder(configuration, body_names(configuration)))


def run_scenario(folder: Path) -> dict[str, str]:
    """Return the fingerprint of a run with a scenario and with commands between its blocks."""
    file = folder / "scenario.yaml"
    file.write_text(SCENARIO)
    configuration = dry_bench("healthy", *EVERY_TOPIC)
    simulation = Simulation(configuration, read_scenario(file, configuration))

    def blocks() -> Iterable[Block]:
        for number, block in enumerate(simulation.blocks(5 * SHORT)):
            yield block
            if number == 3:
                simulation.command_speed(120.0)
            elif number == 5:
                simulation.command_load(1000.0, -90000.0)
            elif number == 7:
                simulation.change({"faults.roller_1.width": 0.003, "faults.roller_1.row": 2, "sensor.range": 300.0})

    return fingerprint(blocks(), BlockEncoder(configuration, body_names(configuration)))


def marks(report: Mapping[str, Any]) -> dict[str, Any]:
    """Return what an exam's report decides: the answers and the confusion; delays and scores belong to the detector, which has changed.

    Verdicts that nobody gave are left out of the confusion, so that a further verdict changes nothing.
    """
    decided = ("name", "verdict", "answer", "passed")
    scenarios = [{key: scenario[key] for key in decided} for scenario in report["scenarios"]]
    confusion = {right: {answer: count for answer, count in row.items() if count} for right, row in report["confusion"].items()}
    return {"passed": report["passed"], "confusion": confusion, "scenarios": scenarios}


def verdicts(report: Mapping[str, Any]) -> dict[str, Any]:
    """Return the verdict of ``dcrb detect --json`` and its counts; levels and scores belong to the detector, which has changed."""
    return {key: report[key] for key in ("verdict", "shaft_frequency", "gaps", "clipped")}


def main() -> None:
    """Print the fingerprints, or write those of the runs."""
    found: dict[str, Any] = json.loads(FILE.read_text()) if FILE.exists() else {}
    with tempfile.TemporaryDirectory() as folder:
        found["cases"] = {name: run(name) for name in (*CASES, *OILED_CASES)} | {"scenario": run_scenario(Path(folder))}
    if "--write" in sys.argv:
        FILE.write_text(json.dumps(found, indent=1) + "\n")
    else:
        print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
