"""The reports in docs/results/exam.md: three exams of the shipped detector, one of the naive detector; recordings are kept."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from result_pages import ROOT, replace_part, today

from dcrb_ros.text.markdown import table

PAGE, IMAGES = ROOT / "docs/results/exam.md", ROOT / "docs/images"
SCORE = [sys.executable, "-c", "from dcrb_ros.cli.app import main; main()", "score"]
MOST_FAILURES = 30


def evaluate(exam: str, image: str, options: list[str]) -> dict[str, Any]:
    """Return the report of an exam as JSON; its figure is written to the documentation's folder of images."""
    # The report contains the command of the detector, which must not depend on the path of the interpreter.
    path = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"}
    command = [*SCORE, exam, "--json", "--figure", str(IMAGES / image), "--force", *options]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False, cwd=ROOT, env=path)
    if done.returncode not in (0, 1) or not done.stdout:
        sys.exit(f"the evaluation of the exam {exam} failed with status {done.returncode}")
    report: dict[str, Any] = json.loads(done.stdout)
    if not report["delay"]:  # there is nothing to draw for healthy runs only
        (IMAGES / image).unlink(missing_ok=True)
    return report


def number(value: float | None, digits: int = 2) -> str:
    """Return a number as text, or a dash for None."""
    return "–" if value is None else f"{value:.{digits}f}"


def interval(estimate: dict[str, Any], digits: int = 2) -> str:
    """Return an estimate with its confidence interval as text."""
    return f"{number(estimate['value'], digits)} ({number(estimate['low'], digits)} to {number(estimate['high'], digits)})"


def report_parts(report: dict[str, Any], image: str, caption: str) -> Iterator[str]:
    """Yield the paragraphs, the figure and the tables of a report in Markdown; one that has nothing to say is empty."""
    scenarios, alarms = report["scenarios"], report["false_alarms"]
    yield (
        f"{len(scenarios)} scenarios, {sum(scenario['duration'] for scenario in scenarios):.0f} s of signal; "
        f"dcrb_ros {report['dcrb_ros']}, model `{report['model']}`, {today()}; scenarios `{report['scenarios_sha256'][:16]}`."
    )
    checks = [(c["name"], c["wanted"], c["got"], "passed" if c["holds"] else "**failed**") for c in report["checks"]]
    yield filled(("criterion", "required", "result", "status"), checks)
    marks = [(name, interval(s, 1), number(s["detection"], 3), number(s["clean"], 3)) for name, s in report["exam_score"].items()]
    yield filled(("profile", "exam score, 95 % confidence", "credit for faults", "factor for false alarms"), marks)
    yield f"![{caption}](../images/{image})" if report["delay"] else ""
    delays = [
        (verdict, f"{d['found']} of {d['asked']}", number(d["median"]), number(d["p95"]), f"{d['limit']:g}")
        for verdict, d in report["delay"].items()
    ]
    yield filled(("fault", "detected", "median delay [s]", "95th percentile [s]", "limit [s]"), delays)
    probability = "probability of detection, 95 % confidence"
    sizes = [
        (d["verdict"], f"{d['width'] * 1e3:g}", f"{d['found']} of {d['asked']}", interval(d["probability"])) for d in report["detection"]
    ]
    yield filled(("fault", "width [mm]", "detected", probability), sizes)
    grades = [
        (d["verdict"], f"`{d['parameter']}`", f"{d['value']:g}", f"{d['found']} of {d['scenarios']}", interval(d["probability"]))
        for d in report["graded_detection"]
    ]
    yield filled(("fault", "parameter", "value", "detected", probability), grades)
    yield (
        f"False alarms: {alarms['count']} in {alarms['healthy_hours'] * 60.0:.1f} min of healthy signal, "
        f"{interval(alarms['per_hour'], 1)} per hour. ROC area: {number(report['roc'] and report['roc']['area'], 3)}."
    )
    wrong = sorted((scenario for scenario in scenarios if not scenario["passed"]), key=lambda scenario: not scenario["required"])
    first = f"; the first {MOST_FAILURES}" if len(wrong) > MOST_FAILURES else ""
    yield f"Errors in {len(wrong)} of {len(scenarios)} scenarios, those required first{first}:" if wrong else ""
    rows = [(f"`{s['name']}`", s["verdict"], s["flaw"], "" if s["required"] else "not required") for s in wrong[:MOST_FAILURES]]
    yield filled(("scenario", "correct verdict", "error", "remark"), rows)


def filled(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table, or nothing if it has no rows."""
    return table(heads, rows) if rows else ""


REPORTS = {
    "shipped": ("standard", [], "The shipped detector's report"),
    "blind": ("blind", [], "The shipped detector's report on other speeds, loads and faults"),
    "graded": ("graded", [], "The shipped detector's report on faults from undetectable to obvious"),
    "hours": ("hours", [], "The shipped detector's report on four healthy hours"),
    "naive": ("smoke", ["--node", "python examples/naive_detector.py"], "The naive detector's report"),
}
"""Exam, options and caption of every report."""


def main() -> None:
    """Evaluate the detectors and write the reports."""
    parser = argparse.ArgumentParser(description=__doc__)
    usual = ["shipped", "blind", "graded", "naive"]
    parser.add_argument("reports", nargs="*", help=f"of {', '.join(REPORTS)}; by default {', '.join(usual)}, which take half an hour")
    parser.add_argument("--recordings", help="folder that keeps the recordings")
    parser.add_argument("--workers", default="0", help="number of parallel runs; 0 for one per core")
    given = parser.parse_args()
    if unknown := set(given.reports) - set(REPORTS):
        parser.error(f"there is no report {', '.join(sorted(unknown))}; there are {', '.join(REPORTS)}")
    options = ["--workers", given.workers, *(["--recordings", given.recordings] if given.recordings else [])]
    for report in given.reports or usual:
        began = time.monotonic()
        exam, exam_options, caption = REPORTS[report]
        image = f"exam-{report}.png"
        parts = report_parts(evaluate(exam, image, options + exam_options), image, caption)
        replace_part(PAGE, f"<!-- report {report} -->", "<!-- end of report -->", "\n\n".join(filter(None, parts)))
        print(f"{report}: {time.monotonic() - began:.0f} s of wall time, using existing recordings")
    print(f"reports: {PAGE}")


if __name__ == "__main__":
    main()
