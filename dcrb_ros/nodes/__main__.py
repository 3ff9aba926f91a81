"""`python -m dcrb_ros.nodes [--with-parent] NAME [ARGUMENTS]`: a node without `ros2 run`.

With ``--with-parent`` it ends with the process that started it, which holds the other end of its standard input.
"""

from __future__ import annotations

import sys

from dcrb_ros.nodes.programs import NAMES, WITH_PARENT, main

with_parent = sys.argv[1:2] == [WITH_PARENT]
arguments = sys.argv[2:] if with_parent else sys.argv[1:]
if not arguments or arguments[0] not in NAMES:
    print(f"usage: python -m dcrb_ros.nodes [{WITH_PARENT}] {{{','.join(NAMES)}}} [ARGUMENTS]", file=sys.stderr)
    sys.exit(2)
main(arguments[0], arguments[1:], with_parent=with_parent)
