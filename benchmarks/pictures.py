"""The pictures of the documentation, each made by a command: ``python benchmarks/pictures.py [NAME ...]``.

Without names, the pictures that are older than what they show are listed with the command that makes them. A picture is stamped in
``docs/images/pictures.json`` when it is made; `picture_stamps.py` says how. Those of measured machines need ``MEASURED``, a folder with
``recordings.csv`` and ``recordings/NAME.npz``.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import picture_drawings as drawings
from picture_stamps import IMAGES, ROOT, changed, stamp, stamps, write_stamps


class Picture(NamedTuple):
    """The command that makes a picture, and the things that it shows."""

    make: str | Callable[[Path], None]
    """Commands of the shell, in which ``{file}`` is the picture and ``{images}`` its folder, or a function that draws it."""
    shows: tuple[str, ...]
    """Each a kind and a text, see `picture_stamps`."""


VIEW = tuple(f"drawing dcrb_ros/viewer/{name}.py" for name in ("bearing_picture", "blueprint", "palette", "series", "spectrum_picture"))
VEHICLE_VIEW = tuple(f"drawing dcrb_ros/viewer/{name}.py" for name in ("plan_view", "palette", "spectrum_picture", "vehicle_content"))
DETECTOR = "detector bags"
OILED = ("samples oiled_healthy", "samples oiled_outer_ring_defect", "samples oiled_inner_ring_defect", "samples oiled_roller_defect")
BURN_OFF = ("bench healthy", "file config/scenarios/burn_off.yaml", "samples thermal")
REPORT = ("drawing dcrb_ros/exam/figure.py", DETECTOR, *OILED, "samples oiled_cage_fracture")
SIM_TO_REAL = (
    "bench ball_bearing_6205",
    "samples balls",
    "samples balls_outer",
    "drawing dcrb_ros/exam/replica_priors.py",
    "drawing benchmarks/sim_to_real_figure.py",
)
DRAWN_ROW = "drawing benchmarks/realism.py:draw_row"
REALISM = ("samples oiled_healthy", "samples oiled_outer_ring_defect", DRAWN_ROW)
SIGNALS = (
    "bench ball_bearing_6205",
    "samples balls_outer",
    "drawing dcrb_ros/exam/replica_priors.py",
    "drawing dcrb_ros/measurement/housing_priors.py",
    DRAWN_ROW,
)
SIGNALS_RUN = "python {root}/benchmarks/signal_realism.py $MEASURED --pictures {images}"
LIVES = ("file config/sweeps/twenty_lives.yaml", "drawing examples/remaining_life.py", "samples oiled_outer_ring_defect")
CALIBRATION = ("bench healthy", "samples oiled_healthy", "drawing dcrb_ros/plots/comparison.py")
SIM_TO_REAL_RUN = "python {root}/benchmarks/sim_to_real.py $MEASURED -o out && "
LIVES_RUN = "dcrb sweep twenty_lives -o lives && python {root}/examples/remaining_life.py lives && "
ABOUT_FAN = (
    "channels: {{ax: a}}\\nsampling_rate: 48000\\nunit: g\\nspeed_rpm: 1796.0\\n"
    "orders: {{FTF: 0.3817, BPFO: 3.053, BPFI: 4.9469, BSF: 1.9937}}\\n"
)
"""Description of the healthy motor bench of Case Western Reserve, fan end."""
STAND_IN = (
    "--set surfaces.seed=4711 --set structure.modes=5 --set structure.seed=11 --set structure.bearing_share=0.3"
    " --set structure.noise_x=0.008 --set structure.noise_y=0.008"
    " --set 'structure.noise_path_x=1500 0.2 4000 0.4' --set 'structure.noise_path_y=1500 0.2 4000 0.4'"
)
"""Settings of the machine of the tutorial on twins."""
BURN_OFF_RUN = "dcrb simulate healthy --scenario burn_off --duration 45 -o burn_off && "


def drawn(draw: Callable[[Path], None], *shows: str) -> Picture:
    """Return a picture that a function of `picture_drawings` draws."""
    return Picture(draw, (*shows, f"drawing benchmarks/picture_drawings.py:{draw.__name__}"))


def exam(report: str, name: str) -> Picture:
    """Return the figure of a report in docs/results/exam.md."""
    return Picture(f"python {{root}}/benchmarks/exam.py {report}", (f"file config/exams/{name}.yaml", *REPORT))


PICTURES = {
    "rerun": Picture(
        "dcrb simulate outer_ring_defect --duration 8 -o outer_ring_defect && dcrb view outer_ring_defect --screenshot {file}",
        ("bench outer_ring_defect", "samples oiled_outer_ring_defect", DETECTOR, *VIEW),
    ),
    "order-map": Picture(
        "printf 'timeline: [{{at: 0.5, over: 6.0, set: {{operating.speed: 150.0}}}}]' > run_up.yaml && dcrb simulate outer_ring_defect"
        " --set operating.speed=40 --scenario run_up.yaml --duration 8 -o run_up && dcrb view run_up --screenshot {file}",
        ("bench outer_ring_defect", "samples oiled_outer_ring_defect", DETECTOR, "drawing dcrb_ros/viewer/order_map.py", *VIEW),
    ),
    "rerun-vehicle": Picture(
        "dcrb simulate --vehicle bogie --duration 4 -o run && dcrb view run --screenshot {file}",
        (
            "file config/vehicles/bogie.yaml",
            "drawing dcrb_ros/vehicle",
            "bench outer_ring_defect",
            "samples oiled_outer_ring_defect",
            DETECTOR,
            *VEHICLE_VIEW,
        ),
    ),
    "rerun-burn-off": Picture(
        BURN_OFF_RUN + "dcrb view burn_off --screenshot {file}", (*BURN_OFF, DETECTOR, *VIEW, "drawing dcrb_ros/viewer/summary.py")
    ),
    "thermal-burn-off": Picture(
        BURN_OFF_RUN + "python {root}/examples/burn_off.py burn_off -o {file}", (*BURN_OFF, "drawing examples/burn_off.py")
    ),
    "detector-spectra": drawn(
        drawings.spectra,
        *(f"bench {name} structure.modes=6" for name in drawings.FAMILIES),
        *OILED,
        "samples oiled_cage_fracture",
        DETECTOR,
    ),
    "detector-sizes": drawn(drawings.sizes, "bench dry", "samples outer_ring_defect", DETECTOR),
    "measurement-faults": drawn(drawings.sensor_faults, "bench outer_ring_defect structure.modes=6", "samples oiled_chain"),
    "measurement-transfer": drawn(drawings.transfer, "drawing dcrb_ros/settings/sensor.py", "samples chain"),
    "measurement-noise": drawn(drawings.noise, "drawing dcrb_ros/settings/sensor.py", "samples chain"),
    "measurement-background": drawn(drawings.background, "samples background"),
    "detector-reliability": Picture(
        "python {root}/benchmarks/reliability.py $MEASURED -o {file}",
        (DETECTOR, "drawing tests/support/jittered_impacts.py", "drawing benchmarks/reliability.py"),
    ),
    "exam-shipped": exam("shipped", "standard"),
    "exam-blind": exam("blind", "blind"),
    "exam-graded": exam("graded", "graded"),
    "exam-naive": exam("naive", "smoke"),
    "exam-unseen": Picture(
        "dcrb exam open {unseen}.sealed.yaml {unseen}.secret -o unseen.yaml && dcrb score unseen.yaml --figure {file} || test -f {file}",
        ("file benchmarks/unseen/unseen.sealed.yaml", *REPORT),
    ),
    "hot-boxes": Picture(
        "python {root}/benchmarks/hot_boxes.py --figure {file}", (DETECTOR, "drawing benchmarks/hot_boxes.py", "samples thermal_faults")
    ),
    "sim-to-real": Picture(SIM_TO_REAL_RUN + "cp out/scores.png {file}", SIM_TO_REAL),
    "sim-to-real-gap": Picture(SIM_TO_REAL_RUN + "cp out/gaps.png {file}", SIM_TO_REAL),
    "realism-healthy": Picture("python {root}/benchmarks/realism.py $MEASURED --pictures {images}", ("bench healthy", *REALISM)),
    "realism-outer": Picture("python {root}/benchmarks/realism.py $MEASURED --pictures {images}", ("bench outer_ring_defect", *REALISM)),
    "signals-outer": Picture(SIGNALS_RUN, ("bench healthy", *SIGNALS)),
    "signals-inner": Picture(SIGNALS_RUN, SIGNALS),
    "predictivity": Picture(
        "python {root}/benchmarks/predictivity.py $MEASURED --leaderboard {root}/docs/leaderboard"
        " --only 'path, impacts and background' -o predictivity.md --figure {file}",
        (
            "bench ball_bearing_6205",
            "file docs/leaderboard/leaderboard.md",
            "drawing dcrb_ros/exam/replica_priors.py",
            "drawing dcrb_ros/exam/predictivity_figure.py",
        ),
    ),
    "calibration-rig": Picture(
        f"cp $MEASURED/recordings/cw48_N_0_FE.npz fan.npz && printf '{ABOUT_FAN}' > about.yaml && dcrb import fan.npz --about about.yaml"
        " -o healthy_run && dcrb calibrate healthy_run --trust -o my_machine.yaml && cp my_machine.png {file}",
        CALIBRATION,
    ),
    "twin-tutorial": Picture(
        f"dcrb simulate healthy -o healthy_run --duration 6 {STAND_IN} && dcrb calibrate healthy_run --base healthy --trust"
        " -o my_machine.yaml && cp my_machine.png {file}",
        CALIBRATION,
    ),
    "lives-severity": Picture(LIVES_RUN + "cp severity.png {file}", LIVES),
    "lives-remaining-life": Picture(LIVES_RUN + "cp remaining-life.png {file}", LIVES),
}


def make(name: str) -> None:
    """Make a picture and stamp it.

    Raises:
        SystemExit: its command failed or wrote no picture.
    """
    picture, file = PICTURES[name], IMAGES / f"{name}.png"
    if callable(picture.make):
        picture.make(file)
    else:
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
        measured = str(Path(os.environ.get("MEASURED", ROOT.parent / "shared/measured")).resolve())
        before = file.stat().st_mtime_ns if file.exists() else None
        with tempfile.TemporaryDirectory() as folder:
            made = Path(folder, file.name)
            line = picture.make.format(file=made, images=folder, unseen=ROOT / "benchmarks/unseen/unseen", root=ROOT)
            done = subprocess.run(line, shell=True, check=False, cwd=folder, env={**os.environ, "PATH": path, "MEASURED": measured})
            if done.returncode:
                sys.exit(f"{name} was not made: its command ended with status {done.returncode}")
            if made.exists():  # an exam writes its figure to the documentation by itself
                shutil.copyfile(made, file)
            elif not file.exists() or file.stat().st_mtime_ns == before:
                sys.exit(f"{name} was not made: its command wrote no picture")
    write_stamp(name)


def write_stamp(name: str) -> None:
    """Write the stamp of a picture: it shows the present state."""
    write_stamps({**stamps(), f"{name}.png": stamp(f"python benchmarks/pictures.py {name}", PICTURES[name].shows)})
    print(f"docs/images/{name}.png", flush=True)


def main() -> None:
    """Make the pictures that are named, or list those that are out of date."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(PICTURES)}")
    parser.add_argument("--stamp", action="store_true", help="stamp the pictures without making them: a change does not alter them")
    given = parser.parse_args()
    names = given.names
    if unknown := sorted(set(names) - set(PICTURES)):
        parser.error(f"there is no picture {', '.join(unknown)}; there are {', '.join(PICTURES)}")
    for name in names:
        (write_stamp if given.stamp else make)(name)
    if not names:
        for file, made in stamps().items():
            if changes := changed(made):
                print(f"docs/images/{file} is older than {', '.join(changes)}: {made['command']}")


if __name__ == "__main__":
    main()
