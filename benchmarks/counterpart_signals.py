"""Statistics of impacts of the counterparts of measured recordings beside those of the recordings (exam-and-measurements.md).

``python benchmarks/counterpart_signals.py MEASURED EXAM --recordings FOLDER`` prints a table for each machine and defect: medians, and how
well a statistic discriminates measured from simulated signals, |2 AUROC - 1|. MEASURED is a folder as for `realism.py`, EXAM a replica of
its table. Recordings that are not in FOLDER are simulated.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from pathlib import Path

import numpy as np
from drawn_machines import TRUTHS
from scipy import stats
from signal_machines import at_rate_of, recordings
from signal_statistics import SignalStatistics

from dcrb_ros.exam.exam_file import read_exam
from dcrb_ros.exam.exam_scenarios import led_signals
from dcrb_ros.text.markdown import table

KINDS = {truth: kind for kind, truth in TRUTHS.items()}


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measured", type=Path)
    parser.add_argument("exam", type=Path)
    parser.add_argument("--recordings", type=Path, required=True)
    given = parser.parse_args()
    measured = recordings(given.measured)
    rows: dict[tuple[str, str], tuple[list[SignalStatistics], list[SignalStatistics]]] = defaultdict(lambda: ([], []))
    seen = set[str]()
    for led in led_signals(read_exam(given.exam), given.recordings):
        name, samples = str(led.recording.tags["recording"]), led.recording.samples()
        case, _, truth = measured[name]
        simulated = case._replace(values=samples - samples.mean(), rate=float(led.recording.rate))
        machine = led.recording.machine.partition("#")[0]  # of which the simulated one is a counterpart
        real, counterparts = rows[machine, KINDS[truth]]
        counterparts.append(simulated.statistics(KINDS[truth]))
        if name not in seen:
            seen.add(name)
            samples = at_rate_of(case, simulated).values[: len(samples)]
            real.append(simulated._replace(values=samples - samples.mean()).statistics(KINDS[truth]))
    for (machine, kind), both in sorted(rows.items()):
        columns = [np.array(side, dtype=float).T for side in both]
        lines = []
        for statistic, real_values, simulated_values in zip(SignalStatistics._fields, *columns, strict=True):
            sides = [values[np.isfinite(values)] for values in (real_values, simulated_values)]
            if all(map(len, sides)):
                auroc = stats.mannwhitneyu(*sides).statistic / (len(sides[0]) * len(sides[1]))
                lines.append((statistic, *(f"{np.median(side):.3g}" for side in sides), f"{abs(2.0 * auroc - 1.0):.2f}"))
        print(f"\n{machine}, {kind}\n\n{table((f'{len(both[0])} recordings', 'measured', f'{len(both[1])} simulated', 'gap'), lines)}")


if __name__ == "__main__":
    main()
