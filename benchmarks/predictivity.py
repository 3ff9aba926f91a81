"""How well replicas of measured recordings predict the marks of detectors on them, with and without each part of the simulation.

``python benchmarks/predictivity.py MEASURED``; MEASURED is a folder with ``recordings.csv`` and ``recordings/NAME.npz``. It rewrites
docs/results/predictivity.md. A second call reads simulated recordings and answers from ``--recordings``. With ``--leaderboard FOLDER`` the
whole replica is compared by the entries of a leaderboard, and no detector runs.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from result_pages import ROOT, commit, today

from dcrb_ros.exam.detector_families import families_of, shipped_members
from dcrb_ros.exam.evaluation import no_progress
from dcrb_ros.exam.exam_file import Exam, exam_of, read_exam
from dcrb_ros.exam.leaderboard import read_entries
from dcrb_ros.exam.limits import Limits
from dcrb_ros.exam.predictivity_figure import write_predictivity_figure
from dcrb_ros.exam.predictivity_report import HEADS, Comparison, compare_entries, compare_with_field, markdown, rows
from dcrb_ros.exam.recording_cache import checked_folder, default_folder
from dcrb_ros.exam.replica import ReplicaPlan, replica_tree
from dcrb_ros.recordings.manifest import model_fingerprint
from dcrb_ros.runtime.linear_algebra import one_thread_each
from dcrb_ros.text.markdown import table
from dcrb_ros.text.writing import write_whole

VARIANTS = {
    "rigid path, equal impacts": ("path", "impacts"),
    "path": ("impacts", "background"),
    "path and impacts": ("background",),
    "path, impacts and background": (),
}
"""Parts that are left out, by what is there; the last is the whole replica."""


def compared(given: argparse.Namespace, without: tuple[str, ...]) -> Comparison:
    """Return the comparison of a replica without some parts."""
    recordings = given.measured / "recordings.csv"
    plan = ReplicaPlan(machines=given.machines, counterparts=given.counterparts, longest=given.longest, without=without)
    with checked_folder(given.recordings) as folder:
        members, broken = families_of(given.detectors, folder)
        if given.published:
            members = [member for member in members if member.published]
        members = [*shipped_members(), *members]

        def replica() -> Exam:
            return exam_of(replica_tree(recordings, plan), "replica")

        return compare_with_field(recordings, replica, members, broken, folder, Limits(), given.workers, no_progress)


def page(comparisons: dict[str, Comparison], source: str) -> str:
    """Return the results page; ``source`` says from what the whole replica was evaluated."""
    whole = comparisons[list(comparisons)[-1]]
    parts = [(name, *rows(one.families[:1])[0][1:]) for name, one in comparisons.items()]
    members = [(name, *rows(one.members[:1])[0][1:]) for name, one in comparisons.items() if one.members != one.families]
    return "\n".join(
        [
            "# Predictivity of the exam",
            "",
            f"Written by `make predictivity` on {today()}, {source}.",
            "[Does an exam predict your rig?](../how-to/predict-your-rig.md) explains the method and the figures. Impacts, housing and",
            "background have priors that follow statistics of these recordings, so this is no test on held-out rigs. No prior was",
            "fitted to the marks of a detector.",
            "",
            "![Marks of detectors in the exam and on measured recordings](../images/predictivity.png)",
            "",
            "## Parts of the simulation",
            "",
            "All recordings; over the families, each with its published settings:",
            "",
            table(("replica", *HEADS[1:]), parts),
            "",
            *(["Over all members:", "", table(("replica", *HEADS[1:]), members), ""] if members else []),
            "## The whole replica",
            "",
            markdown(whole),
            "",
        ]
    )


def main() -> int:
    """Compare every variant and write the page and its figure."""
    one_thread_each()  # of the processes in which detectors run
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("measured", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs" / "results" / "predictivity.md")
    parser.add_argument("--figure", type=Path, default=ROOT / "docs" / "images" / "predictivity.png")
    parser.add_argument("--detectors", type=Path, default=ROOT / "examples" / "detectors")
    parser.add_argument("--recordings", type=Path, default=default_folder())
    parser.add_argument("--machines", type=int, default=6)
    parser.add_argument("--counterparts", type=int, default=3)
    parser.add_argument("--longest", type=float, default=ReplicaPlan.longest)
    parser.add_argument("--published", action="store_true", help="only the published settings of each family but the shipped one")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--leaderboard", type=Path, help="folder with entries, and with those on MEASURED in its subfolder measured/")
    parser.add_argument("--replica", type=Path, default=ROOT / "examples" / "detectors" / "exam.yaml", help="exam of these entries")
    parser.add_argument("--only", nargs="+", choices=list(VARIANTS), help="default: all, and with --leaderboard the last")
    given = parser.parse_args()
    if not (given.measured / "recordings.csv").is_file():
        print(
            f"{given.measured} has no recordings.csv, so nothing is compared: the recordings are not part of the repository",
            file=sys.stderr,
        )
        return 0
    comparisons = {}
    for name in given.only or list(VARIANTS)[-1 if given.leaderboard else 0 :]:
        if given.leaderboard is not None and not VARIANTS[name]:
            entries = read_entries(given.leaderboard), read_entries(given.leaderboard / "measured")
            comparisons[name] = compare_entries(given.measured / "recordings.csv", read_exam(given.replica), *entries)
        else:
            comparisons[name] = compared(given, VARIANTS[name])
        print(f"{name}\n{markdown(comparisons[name])}", flush=True)
    source = f"model `{model_fingerprint()}`, with the rules of the shipped detector of commit `{commit()}`"
    if given.leaderboard is not None:
        models = sorted({entry.model for entry in read_entries(given.leaderboard)})
        source = f"from the entries of the [leaderboard](../leaderboard/leaderboard.md), model `{', '.join(models)}`"
    write_whole(given.output, page(comparisons, source))
    write_predictivity_figure(comparisons[list(comparisons)[-1]], given.figure)
    return 0


if __name__ == "__main__":
    sys.exit(main())
