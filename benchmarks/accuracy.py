"""Accuracy of the time loop: order of convergence, forces and waveform of a defect, statistics over seconds, energy.

Prints Markdown tables. A row with a tolerance has a verdict; the exit status is 1 if a row exceeds its tolerance.
"""

from __future__ import annotations

import argparse
import sys

from accuracy_energy import energy_table
from accuracy_order import order_table
from accuracy_statistics import statistics_table
from accuracy_waveform import path_table


def main() -> int:
    """Print the tables; return 1 if a tolerance is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="leave out the statistics over seconds")
    quick = parser.parse_args().quick
    passed = [order_table(), path_table(), True if quick else statistics_table(), energy_table()]
    return 0 if all(passed) else 1


if __name__ == "__main__":
    sys.exit(main())
