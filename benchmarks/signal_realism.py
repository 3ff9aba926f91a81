"""Statistics of impacts of simulated bearings beside those of measured rigs, for docs/results/signals.md.

``python benchmarks/signal_realism.py MEASURED -o FOLDER [--page FILE] [--machines 16]``; MEASURED is a folder as for `realism.py`. The
statistics of each variant are kept in FOLDER, and a second call of the same model continues. ``--page`` rewrites the part of a page between
its marks. With ``--pictures DIRECTORY`` it draws the pictures instead.
"""

from __future__ import annotations

import argparse
import itertools
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from drawn_machines import TRUTHS
from kept_results import digest_of
from realism import draw
from result_pages import commit, replace_part, today
from signal_machines import (
    RIGS,
    Case,
    Row,
    case_of,
    machines_of,
    measured_rows,
    order_of,
    read_rows,
    recordings,
    run_of,
    simulated_rows,
    write_rows,
)
from signal_page import aims_table, statistics_table

from dcrb_ros.exam.measured import TABLE, files_hash, read_measured
from dcrb_ros.exam.replica import table_digest

KINDS = {
    "outer": "Defects of the outer ring",
    "inner": "Defects of the inner ring",
    "ball": "Defects of balls",
    "healthy": "Healthy bearings",
}
VARIANTS = {
    "equal": {"ring": "ring, equal impacts", "sensor": "housing, equal impacts"},
    "drawn": {"ring": "ring, unequal impacts", "sensor": "all"},
}
"""The parts of the model by drawing and place: housing, impacts that differ, and background."""
SHOWN = tuple(name for names in VARIANTS.values() for name in names.values())
PICTURED = {"outer": (("6205", 1), ("6205", 2), ("axle box", 1)), "inner": (("6205", 1), ("6205", 2))}
"""Bearing and number of the simulated machines by kind of defect."""
MARKS = "<!-- begin of the tables -->", "<!-- end of the tables -->"


def key(bearing: str, variant: str, kind: str) -> str:
    """Return the name of a group of signals."""
    return f"{bearing}: {variant}: {kind}"


def simulated(folder: Path, bearing: str, machines: int) -> dict[str, list[Row]]:
    """Return the rows of all variants of a simulated bearing, continued from a folder."""
    groups: dict[str, list[Row]] = defaultdict(list)
    for number, (drawing, variants) in itertools.product(range(machines), VARIANTS.items()):
        path = folder / f"{bearing.replace(' ', '-')}-{drawing}-{number + 1}-{digest_of()}.json"
        if not path.exists():
            found: dict[str, list[Row]] = defaultdict(list)
            for place, kind, row in simulated_rows(bearing, machines_of(bearing, drawing, machines)[number], str(number + 1)):
                found[key(bearing, variants[place], kind)].append(row)
            write_rows(path, found)
            print(f"{bearing}, {drawing}, machine {number + 1}", flush=True)
        for name, rows in read_rows(path).items():
            groups[name] += rows
    return groups


def measured(folder: Path, output: Path) -> dict[str, list[Row]]:
    """Return the rows of the measured rigs by rig and kind of defect."""
    path = output / f"measured-{digest_of(table_digest(folder / TABLE), files_hash(read_measured(folder)))}.json"
    if not path.exists():
        write_rows(path, {f"{rig}: {kind}": measured_rows(folder, rig, kind) for rig in RIGS for kind in KINDS})
    return read_rows(path)


def page(rigs: dict[str, list[Row]], groups: dict[str, list[Row]], machines: int) -> Iterator[str]:
    """Yield the headings and tables in Markdown."""
    yield f"`python benchmarks/signal_realism.py`, {machines} machines, {today()}, commit `{commit()}`."
    yield "## Expected ranges"
    yield aims_table(lambda variant, kind: groups.get(key("6205", variant, kind), []), SHOWN)
    for kind, title in KINDS.items():
        yield f"## {title}"
        shown = {rig: rigs[f"{rig}: {kind}"] for rig in RIGS if rigs[f"{rig}: {kind}"]}
        shown |= {f"6205, {variant}": groups[key("6205", variant, kind)] for variant in SHOWN}
        shown |= {f"axle box, {v}": groups[key("axle box", v, kind)] for v in SHOWN if groups.get(key("axle box", v, kind))}
        yield statistics_table(shown)


def typical(folder: Path, rig: str, kind: str) -> Case:
    """Return the recording of a rig with a kind of defect whose R is the median, the lower one of two."""
    found = [case for case, its, truth in recordings(folder).values() if (its, truth) == (RIGS[rig][0], TRUTHS[kind])]
    ranked = sorted(found, key=lambda case: case.ratio(kind))
    return ranked[(len(ranked) - 1) // 2]


def draw_pictures(folder: Path, pictures: Path) -> None:
    """Draw the recordings with the median R of each rig beside the first simulated machines, a picture for each kind of defect."""
    for kind in PICTURED:
        cases = [typical(folder, rig, kind) for rig in RIGS]
        for bearing, number in PICTURED[kind]:
            run = run_of(bearing, machines_of(bearing, "drawn", number)[-1], kind)
            cases.append(case_of(run, f"simulated: {bearing}, machine {number}", ring=False))
        line = "BPFO" if kind == "outer" else "BPFI"
        draw(pictures / f"signals-{kind}.png", cases, [order_of(case.orders, kind) for case in cases], line)


def main() -> None:
    """Simulate what is missing, and print the tables or write them to a page; or draw the pictures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measured", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("signals"))
    parser.add_argument("--machines", type=int, default=16)
    parser.add_argument("--boxes", type=int, default=8)
    parser.add_argument("--page", type=Path)
    parser.add_argument("--pictures", type=Path, help="folder of the pictures; then no tables are made")
    given = parser.parse_args()
    if given.pictures:
        draw_pictures(given.measured, given.pictures)
        return
    given.output.mkdir(parents=True, exist_ok=True)
    rigs = measured(given.measured, given.output)
    groups = simulated(given.output, "6205", given.machines) | simulated(given.output, "axle box", given.boxes)
    text = "\n\n".join(page(rigs, groups, given.machines)) + "\n"
    if given.page is None:
        print(text)
    else:
        replace_part(given.page, *MARKS, f"\n{text}")


if __name__ == "__main__":
    main()
