"""``SHA256SUMS``: the hashes of the tables and descriptions of a data set, which ``sha256sum -c`` checks, too.

The table of labels has the hashes of all other files.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.store import Store

SUMS = "SHA256SUMS"
LINE = re.compile(r"([0-9a-f]{64})  ([\w.-]+)")


def write_sums(store: Store, names: Sequence[str]) -> None:
    """Write the hashes of some files of a data set."""
    store.write(SUMS, "".join(f"{store.sha256(name, remote=True)}  {name}\n" for name in sorted(names)).encode())


def read_sums(store: Store) -> dict[str, str] | None:
    """Return the hashes of the tables and descriptions by their names; None if the data set has none.

    Raises:
        Refusal: the file is damaged.
    """
    data = store.read(SUMS)
    if data is None:
        return None
    lines = [LINE.fullmatch(line) for line in data.decode(errors="replace").splitlines()]
    sums = {line[2]: line[1] for line in lines if line is not None}
    if not sums or None in lines:
        raise Refusal(f"{store.path(SUMS)} is damaged: repeat the command that made the data set")
    return sums
