"""`dcrb shards`: WebDataset shards of a data set, and any of them made again from the index."""

from __future__ import annotations

from typing import Annotated

import typer

from dcrb_ros.cli.options import refuse_given
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.counts import counted


def shards(
    context: typer.Context,
    source: Annotated[str, typer.Argument(help="Folder of a data set; with --remake the index.json of shards.")],
    output: Annotated[str, typer.Option("-o", "--output", help="New folder of the shards; with --remake the new shard.")],
    runs: Annotated[int, typer.Option(min=1, max=1_000_000, help="Least number of runs in a shard.")] = 100,
    remake: Annotated[
        str | None, typer.Option(help="Simulate this shard again from the index alone, such as train-000003.tar, and compare its bytes.")
    ] = None,
) -> None:
    """Pack a data set into WebDataset shards with an index from which every shard can be made again, bit for bit.

    Example: dcrb shards my_data_set -o shards --runs 200
    """
    from dcrb_ros.sweep.shards import remake_shard, write_shards
    from dcrb_ros.sweep.store import local_folder

    given, new = local_folder(source), local_folder(output)
    if remake is None:
        names = write_shards(given, new, runs)
        print(f"{new}: {counted(len(names), 'shard')} and the index")
        return
    refuse_given(context, "does not apply to --remake, which makes the shard as the index describes it: leave it out", "runs")
    if new.exists():
        raise Refusal(f"-o {new} exists: give a new file")
    print(f"{new}: made again with the SHA-256 {remake_shard(given, remake, new)} of the index")
