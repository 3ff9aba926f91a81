"""`python -m dcrb_ros.nodes NAME [ARGUMENTS]`: a node without `ros2 run`."""

from __future__ import annotations

import sys

from dcrb_ros.nodes.programs import NAMES, main

if len(sys.argv) < 2 or sys.argv[1] not in NAMES:
    sys.exit(f"usage: python -m dcrb_ros.nodes {{{','.join(NAMES)}}} [ARGUMENTS]")
main(sys.argv[1], sys.argv[2:])
