"""What the random hostile inputs are made from: a sound file of every kind, and the commands that read it."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from hostile_corpus import INPUT, NEW
from hostile_mutations import Target, changed_bytes, changed_database, changed_json, changed_table, changed_yaml
from made_up_blocks import narrowed, recorded
from ros2_bag_record import bag_of, messages_of
from scipy.io import savemat

from dcrb_ros.settings.shipped import shipped_folder
from dcrb_ros.sweep.verification import DIGEST
from dcrb_ros.text.json import digest_of

ROOT = Path(__file__).parents[2]
ORDERS = {"FTF": 0.39828, "BPFO": 3.5848, "BPFI": 5.4152, "BSF": 2.35695}
ABOUT = {"channels": {"ax": "de"}, "unit": "g", "speed_rpm": 1797, "sampling_rate": 12000, "orders": ORDERS}
BENCHES = ("healthy", "compound", "dry", "paper", "tapered_352213", "spherical_22205", "za2115", "ball_bearing_6205", "cage_fracture")
SCENARIOS = ("run_up", "stop_and_go", "growing_spall", "failing_sensor", "reversal", "on_the_track")
SWEEPS = ("two_hundred", "twin", "ten_lives", "life")
SWEEP = {
    "base": "dry",
    "set": {"cage.joint": "revolute"},
    "duration": 0.02,
    "vary": {"operating.speed": [100.0, 120.0]},
    "windows": {"length": 256},
}
TEMPLATE = {
    "exam": "autumn",
    "duration": 9.0,
    "onset": 4.0,
    "scenarios": [
        {
            "name": "outer",
            "verdict": "outer_ring",
            "count": 4,
            "draw": {
                "set": {"operating.speed": {"low": 60.0, "high": 190.0}, "sensor.preset": ["ideal", "mems"]},
                "fault": {"faults.outer_1.width": {"low": 0.0004, "high": 0.003, "scale": "log"}},
            },
        },
        {"name": "well", "verdict": "healthy"},
    ],
}
CONFIGURATION = ("config", "check", INPUT)
TABLE_COMMANDS = (("exam", "replica", INPUT, "-o", f"{NEW}.yaml", "--without", "background"), ("score", "--measured", "TABLE", "--list"))


class Material:
    """Sound files in a folder, made once; each is named by a word that stands for its path in commands."""

    def __init__(self, folder: Path, dcrb: Callable[..., Any]) -> None:
        """Make the files; ``dcrb`` runs a command."""
        self.folder, self._dcrb = folder, dcrb
        self.words: dict[str, str] = {}
        self._recordings()
        self._tables()
        self._data_set()
        self._exam()
        self._vehicle()

    def _run(self, *arguments: str) -> None:
        found = self._dcrb(*arguments, seconds=600.0)
        assert found.status == 0, (arguments, found)

    def _recordings(self) -> None:
        self.words["GOOD"] = str(recorded(self.folder / "good", 3))
        self.words["LONG"] = str(narrowed(self.folder / "long", 150, at=1000, limit=5000.0))
        bag_of(self.folder / "ros2", messages_of(150), "sqlite3")
        bag = str(ROOT / "bags" / "healthy")
        self._run("detect", bag, "--healthy", bag, "--save-baseline", str(self.folder / "baseline.yaml"))
        np.savez(self.folder / "wave.npz", de=np.sin(np.arange(4000.0)))
        savemat(self.folder / "wave.mat", {"de": np.sin(np.arange(4000.0))})
        (self.folder / "wave.csv").write_text("de\n" + "".join(f"{np.sin(k):.6f}\n" for k in range(4000)))
        (self.folder / "about.yaml").write_text(yaml.safe_dump(ABOUT))
        self.words |= {"WAVE": str(self.folder / "wave.npz"), "ABOUT": str(self.folder / "about.yaml")}

    def _tables(self) -> None:
        rows = (("calm_1", "healthy", 1800), ("calm_2", "healthy", 1200), ("outer_1", "outer_ring", 1800), ("outer_2", "outer_ring", 1200))
        head = ["name", "rig", "truth", "sampling_rate", "unit", "speed_rpm_documented", "speed_rpm_from_lines", *ORDERS, "seconds", "load"]
        head += ["pitch_diameter_mm", "gain", "machine", "bearing"]
        lines = [",".join(head)]
        for name, truth, rpm in rows:
            orders = [str(value) for value in ORDERS.values()]
            lines.append(
                ",".join([name, "bench12", truth, "12000", "g", f"{rpm}", f"{rpm}", *orders, "10", "1500", "39", "known", "m", name])
            )
        (self.folder / "recordings.csv").write_text("\n".join(lines) + "\n")
        (self.folder / "recordings").mkdir()
        for name, _, _ in rows:
            np.savez(self.folder / "recordings" / f"{name}.npz", a=np.random.default_rng(1).normal(size=12000))
        self._run(
            "exam", "replica", str(self.folder / "recordings.csv"), "-o", str(self.folder / "replica.yaml"), "--without", "background"
        )
        (self.folder / "list.csv").write_text(
            "file,fault,name,split,bearing_id,width,load,about,speed_rpm\n"
            f"wave.npz,healthy,a,train,b1,,1000,{self.words['ABOUT']},1797\n"
            f"wave.csv,outer_ring,b,test,b2,0.001,1000,{self.words['ABOUT']},1750\n"
        )

    def _data_set(self) -> None:
        (self.folder / "sweep.yaml").write_text(yaml.safe_dump(SWEEP))
        self._run("sweep", str(self.folder / "sweep.yaml"), "-o", str(self.folder / "set"), "--workers", "1")
        self._run("shards", str(self.folder / "set"), "-o", str(self.folder / "shards"))
        shard = next((self.folder / "shards").glob("*.tar"))
        self.words |= {"SWEEP": str(self.folder / "sweep.yaml"), "SHARD": shard.name}

    def _exam(self) -> None:
        (self.folder / "template.yaml").write_text(yaml.safe_dump(TEMPLATE))
        sealed, secret = str(self.folder / "sealed.yaml"), str(self.folder / "secret")
        self._run("exam", "seal", str(self.folder / "template.yaml"), "-o", sealed, "--secret", secret)
        self.words |= {"SEALED": sealed, "SECRET": secret}

    def _vehicle(self) -> None:
        self._run("simulate", "dry", "--duration", "0.05", "-o", str(self.folder / "simulated"), "--quiet")
        self._run("simulate", "--vehicle", "healthy_bogie", "--duration", "0.1", "-o", str(self.folder / "run"), "--quiet")
        self.words["RUN"] = str(self.folder / "run")

    def read(self, name: str) -> bytes:
        return (self.folder / name).read_bytes()

    def copied(self, name: str, target: Path, file: str, content: bytes) -> None:
        """Copy a folder, and give one of its files another content."""
        shutil.copytree(self.folder / name, target)
        (target / file).write_bytes(content)


def _signed_label(tree: dict[str, Any]) -> dict[str, Any]:
    return tree | {DIGEST: digest_of(tree, DIGEST)}


def targets(material: Material) -> dict[str, Target]:
    """Return every kind of input by its name. A name with a colon is a file in a copied folder: FOLDER:FILE."""
    shipped = shipped_folder()
    found: dict[str, Target] = {}

    def add(name: str, content: bytes, change: Any, *commands: tuple[str, ...], suffix: str = ".yaml") -> None:
        found[name] = Target(content, change, commands, suffix)

    for bench in BENCHES:
        add(f"bench {bench}", (shipped / f"{bench}.yaml").read_bytes(), changed_yaml(), CONFIGURATION)
    full = yaml.safe_dump(yaml.safe_load(material.read("set/base.yaml")) if (material.folder / "set/base.yaml").is_file() else {})
    add("bench with every key", full.encode(), changed_yaml(), CONFIGURATION)
    for scenario in SCENARIOS:
        command = ("simulate", "healthy", "--scenario", INPUT, "-o", NEW, "--duration", "0.01", "--quiet")
        add(f"scenario {scenario}", (shipped / "scenarios" / f"{scenario}.yaml").read_bytes(), changed_yaml(), command)
    for exam in ("smoke", "graded", "lubrication", "blind"):
        add(
            f"exam {exam}", (shipped / "exams" / f"{exam}.yaml").read_bytes(), changed_yaml(frozenset({"tags"})), ("score", INPUT, "--list")
        )
    for sweep in SWEEPS:
        add(f"sweep {sweep}", (shipped / "sweeps" / f"{sweep}.yaml").read_bytes(), changed_yaml(), ("sweep", INPUT, "--dry-run"))
    add("small sweep", material.read("sweep.yaml"), changed_yaml(), ("sweep", INPUT, "--dry-run"))
    for vehicle in ("bogie", "healthy_bogie"):
        command = ("simulate", "--vehicle", INPUT, "--duration", "0.004", "-o", NEW, "--quiet")
        add(f"vehicle {vehicle}", (shipped / "vehicles" / f"{vehicle}.yaml").read_bytes(), changed_yaml(), command)
    add("detector", (shipped / "detector.yaml").read_bytes(), changed_yaml(), ("detect", "LONG", "--detector", INPUT))
    add("baseline", material.read("baseline.yaml"), changed_yaml(), ("detect", "LONG", "--baseline", INPUT))
    add("description", material.read("about.yaml"), changed_yaml(), ("import", "WAVE", "--about", INPUT, "-o", NEW))
    add("replica", material.read("replica.yaml"), changed_yaml(frozenset({"tags"})), ("score", INPUT, "--list"))
    add("template", material.read("template.yaml"), changed_yaml(), ("exam", "seal", INPUT, "-o", NEW, "--secret", f"{NEW}.s"))
    add(
        "sealed exam",
        material.read("sealed.yaml"),
        changed_yaml(),
        ("exam", "verify", INPUT, "SECRET"),
        ("exam", "open", INPUT, "SECRET", "-o", NEW),
    )
    add("secret", material.read("secret"), changed_bytes, ("exam", "verify", "SEALED", INPUT), ("exam", "open", "SEALED", INPUT, "-o", NEW))

    add("table of a replica", material.read("recordings.csv"), changed_table, TABLE_COMMANDS[0], suffix=".csv")
    add("list to collect", material.read("list.csv"), changed_table, ("collect", "LIST", "-o", NEW), suffix=".csv")

    commands = {
        "info": ("good", ("info", INPUT)),
        "detect": ("long", ("detect", INPUT)),
        "export": ("good", ("export", INPUT, "-o", f"{NEW}.npz")),
        "recover": ("good", ("recover", INPUT, "-o", NEW)),
        "score": ("long", ("score", INPUT, "--reference")),
        "view": ("good", ("view", INPUT, "--save", f"{NEW}.rrd")),
    }
    for name, (folder, command) in commands.items():
        bag = next((material.folder / folder).glob("*.mcap"))
        add(f"recording, {name}", bag.read_bytes(), changed_bytes, command, suffix=".mcap")
    simulated = next((material.folder / "simulated").glob("*.mcap"))
    add("recording, from", simulated.read_bytes(), changed_bytes, ("simulate", "--from", INPUT, "--quiet"), suffix=".mcap")
    bag = next((material.folder / "ros2").glob("*.db3"))
    add("recording, SQLite", bag.read_bytes(), changed_database, *(command for _, command in commands.values()), suffix=".db3")
    about = ("import", INPUT, "--about", "ABOUT", "-o", NEW)
    for suffix in ("npz", "mat", "csv"):
        add(f"waveform {suffix}", material.read(f"wave.{suffix}"), changed_bytes, about, suffix=f".{suffix}")

    label = next((material.folder / "set" / "labels").glob("*.json"))
    sweep_again, pack = ("sweep", "SWEEP", "-o", INPUT, "--workers", "1"), ("shards", INPUT, "-o", NEW)
    add(f"set:labels/{label.name}", label.read_bytes(), changed_json(sign=_signed_label), pack, pack, pack, sweep_again)
    for file in ("about.json", "sums.json"):
        if (material.folder / "set" / file).is_file():
            add(f"set:{file}", material.read(f"set/{file}"), changed_json(), pack, pack, pack, sweep_again)
    add(
        "shards:index.json",
        material.read("shards/index.json"),
        changed_json(),
        ("shards", f"{INPUT}/index.json", "-o", f"{NEW}.tar", "--remake", "SHARD"),
    )
    box = next(iter(sorted((material.folder / "run").rglob("*.mcap"))))
    relative = box.relative_to(material.folder / "run")
    add(f"run:{relative}", box.read_bytes(), changed_bytes, ("simulate", "--from", INPUT, "--quiet"))
    return found
