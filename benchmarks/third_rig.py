"""How well replicas predict the marks of detectors on a rig that no prior has seen: priors of two rigs, tested on the third.

``python benchmarks/third_rig.py MEASURED -o FOLDER [OPTIONS]`` writes a page as `predictivity.py` does for every rig to FOLDER, and
prints a table. OPTIONS are those of `predictivity.py`. Every prior that follows the rigs is moved by the ratio of a statistic over the two
others to the same statistic over all three, before any detector runs:

* spread of impacts: scatter of energy of outer rings; spread of times: shared jitter of outer rings;
* shares of the element and of the shaft: squared depth of the lines of the cage, and of the sidebands, of outer rings over the squared
  scatter;
* axial share: sidebands of inner rings, which fall by 0.65 per unit of the share;
* floors: minus the crest of the envelope of each ring; participation: power of outer rings from 5 to 20 kHz (HIT and MFPT);
* loss: excess kurtosis of outer rings, which grows with the loss to the power of 0.57, kept within 0.03 to 0.2.

The spreads of the priors, the background and the share of lines stay as they are.
"""

from __future__ import annotations

import argparse
import csv
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from result_pages import ROOT
from signal_machines import RIGS, Row
from signal_realism import measured

from dcrb_ros.exam.replica_priors import PRIORS
from dcrb_ros.measurement.housing_priors import FLOORS, LABORATORY, Beta, Lognormal, Uniform
from dcrb_ros.text.markdown import table
from dcrb_ros.text.writing import write_whole

WHOLE = "path, impacts and background"
RECORDED = {"CWRU": ("cwru12", "cwru48"), "HIT": ("hitself",), "MFPT": ("mfpt",)}
"""Rigs of the table with the bearing of each rig; the fan end of CWRU has another one."""
SIDEBANDS_BY_SHARE = -0.65
"""Change of the sidebands of inner rings by the axial share: 0.94 without and 0.58 with a mean share of 0.55, docs/results/signals.md."""
KURTOSIS_BY_LOSS = 0.57
"""Exponent of the excess kurtosis of outer rings over the loss: 2.9 with a loss of 0.035 and 5.3 with 0.1, medians of replicas."""
LOSSES = (0.03, 0.2)
"""Range of the loss factor at 1 kHz [-]: about the 0.02 to 0.13 measured on decays of HIT and MFPT."""
AXIAL_SHARES = (0.0, 0.8)
"""Range of the axial share that the bench takes [-]."""

Rows = Mapping[str, list[Row]]
Mean = Callable[[str, str], float]
"""Mean over rigs of the median of a statistic of a kind of defect."""


def mean_of(rows: Rows, rigs: list[str]) -> Mean:
    """Return the mean over some rigs; rigs that do not have the statistic are left out."""

    def mean(kind: str, name: str) -> float:
        values = [np.array([getattr(row.statistics, name) for row in rows[f"{rig}: {kind}"]]) for rig in rigs]
        return float(np.mean([np.nanmedian(of_rig) for of_rig in values if not np.isnan(of_rig).all()]))

    return mean


def excess(mean: Mean) -> float:
    """Return the mean excess kurtosis of outer rings [-]."""
    return mean("outer", "kurtosis") - 3.0


def power(mean: Mean) -> float:
    """Return the mean level of outer rings from 5 to 20 kHz [dB]."""
    return 0.5 * (mean("outer", "middle") + mean("outer", "upper"))


def moved_priors(two: Mean, three: Mean) -> tuple[str, str]:
    """Return what is appended to `housing_priors` and to `replica_priors`, from means over two rigs and over all three."""

    def ratio(name: str) -> float:
        return two("outer", name) / three("outer", name)

    scatter = ratio("energy_scatter")
    loss = float(np.clip(LABORATORY.loss.median * (excess(two) / excess(three)) ** (1.0 / KURTOSIS_BY_LOSS), *LOSSES))
    participation = LABORATORY.participation.median * 10.0 ** ((power(two) - power(three)) / 20.0)
    floors = {
        part: Lognormal(FLOORS[part].median * 10.0 ** ((three(part, "crest") - two(part, "crest")) / 10.0), FLOORS[part].factor)
        for part in ("outer", "inner")
    }
    shift = (two("inner", "sidebands") - three("inner", "sidebands")) / SIDEBANDS_BY_SHARE
    found = {prior.key: prior.distribution for prior in PRIORS if prior.bench == "balls"}
    new: dict[str, Lognormal | Beta | Uniform] = {}
    for key, distribution in found.items():
        match key, distribution:
            case "impacts.spread", Lognormal(median, factor):
                new[key] = Lognormal(median * scatter, factor)
            case "impacts.time_spread", Lognormal(median, factor):
                new[key] = Lognormal(median * ratio("jitter"), factor)
            case "impacts.axial_share", Uniform(low, high):
                new[key] = Uniform(max(low + shift, AXIAL_SHARES[0]), min(high + shift, AXIAL_SHARES[1]))
            case (("impacts.element_share" | "impacts.shaft_share"), Beta(_, b)):
                line = ratio("cage" if "element" in key else "sidebands")
                new[key] = Beta(1.0, 1.0 / float(np.clip((line / scatter) ** 2 / (1.0 + b), 0.02, 0.6)) - 1.0)
    housing = (
        f"\nLABORATORY = LABORATORY._replace(loss=LABORATORY.loss._replace(median={loss:.4g}), "
        f"participation=LABORATORY.participation._replace(median={participation:.4g}))\n"
        f'PRIORS["laboratory"] = LABORATORY\nFLOORS.update({floors!r})\n'
    )
    replica = (
        f"\n_MOVED = {new!r}\n"
        "import dataclasses\n"
        "PRIORS = tuple(\n"
        "    dataclasses.replace(p, distribution=_MOVED.get(p.key, p.distribution)) if p.bench == 'balls' else p for p in PRIORS\n"
        ")\n"
    )
    return housing, replica


def copied(folder: Path, appended: tuple[str, str]) -> None:
    """Copy the package to a folder, with something appended to its priors."""
    for name in ("dcrb_ros", "config", "examples", "benchmarks"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    for module, text in zip(("measurement/housing_priors.py", "exam/replica_priors.py"), appended, strict=True):
        path = folder / "dcrb_ros" / module
        write_whole(path, path.read_text() + text)
    history = subprocess.run(["git", "rev-parse", "--absolute-git-dir"], stdout=subprocess.PIPE, text=True, check=True, cwd=ROOT).stdout
    (folder / ".git").write_text(f"gitdir: {history}")


def write_table(source: Path, rig: str, folder: Path) -> None:
    """Write the table of the recordings of one rig, beside a link to all recordings."""
    with (source / "recordings.csv").open(newline="") as file:
        head, *lines = list(csv.reader(file))
    kept = [line for line in lines if line[head.index("rig")] in RECORDED[rig]]
    with (folder / "recordings.csv").open("w", newline="") as file:
        csv.writer(file).writerows([head, *kept])
    (folder / "recordings").symlink_to((source / "recordings").resolve())


def compare(source: Path, rig: str, rows: Rows, output: Path, options: list[str]) -> list[str]:
    """Compare a rig with replicas whose priors follow the two others; return the figures over the families."""
    others = [name for name in RIGS if name != rig]
    appended = moved_priors(mean_of(rows, others), mean_of(rows, list(RIGS)))
    write_whole(output / f"priors-{rig}.txt", "".join(appended))
    with tempfile.TemporaryDirectory() as temporary:
        copy, own = Path(temporary, "copy"), Path(temporary, "measured")
        copied(copy, appended)
        own.mkdir()
        write_table(source, rig, own)
        page = output / f"{rig}.md"
        command = [sys.executable, str(copy / "benchmarks" / "predictivity.py"), str(own), "-o", str(page), "--only", WHOLE]
        command += ["--figure", str(output / f"{rig}.png"), "--detectors", str(copy / "examples" / "detectors"), *options]
        subprocess.run(command, check=True, env=os.environ | {"PYTHONPATH": str(copy)}, cwd=ROOT)
    row = re.search(rf"^\| {WHOLE} \|(.*)\|$", page.read_text(), re.MULTILINE)
    if row is None:
        raise ValueError(f"{page} has no row of the whole replica")
    return [cell.strip() for cell in row[1].split("|")]


def main() -> None:
    """Compare every rig, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measured", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--rigs", nargs="+", choices=list(RIGS), default=list(RIGS))
    given, options = parser.parse_known_args()
    given.output.mkdir(parents=True, exist_ok=True)
    rows = measured(given.measured, given.output)
    figures = [(rig, *compare(given.measured, rig, rows, given.output, options)) for rig in given.rigs]
    print(table(("tested on", "SRCC", "rho", "tau-b", "MMRV"), figures))


if __name__ == "__main__":
    main()
