"""Arguments, checks and messages shared by several commands."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.schema.refusal import Refusal

MOST_WORKERS = 256
"""Largest number of parallel runs that is accepted [-]."""

Bag = Annotated[Path, typer.Argument(help="Recording: its folder, or a single .mcap file.")]
Config = Annotated[str, typer.Argument(help="Configuration: a YAML file or a shipped name, such as outer_ring_defect.")]
Duration = Annotated[float, typer.Option(help="Simulated time in seconds, above 0 and up to 1e6.")]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", help="Override a parameter, KEY=VALUE, such as operating.speed=100.0 (rad/s); may be repeated."),
]
Scenario = Annotated[
    Path | None,
    typer.Option(help="Scenario: a YAML file or a shipped name; a timeline of speed, load, faults and sensor in simulated time."),
]
DetectorFile = Annotated[
    Path | None,
    typer.Option(help="Parameters of the shipped detector: a YAML file, such as a copy of config/detector.yaml. Default: built-in values."),
]
JsonOutput = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]
Workers = Annotated[int, typer.Option(help=f"Number of parallel runs, 0 to {MOST_WORKERS}; 0 uses all cores.")]


def worker_count(workers: int) -> int:
    """Return the number of processes for the option --workers; 0 gives one per core.

    Raises:
        Refusal: the number is out of range.
    """
    if not 0 <= workers <= MOST_WORKERS:
        raise Refusal(f"--workers {workers} is outside 0 .. {MOST_WORKERS}: give the number of parallel runs, 0 for one per core")
    from dcrb_ros.runtime.processes import cores

    return workers or cores()


def literal(*texts: str) -> tuple[str, ...]:
    """Return texts that rich prints literally: units in brackets are not read as markup."""
    from rich.markup import escape

    return tuple(map(escape, texts))


def announce_compilation() -> None:
    """Print a note if the kernels have to be compiled first."""
    from dcrb_ros.core import compiled

    if not compiled():
        typer.echo("compiling the kernels (once, about half a minute) ...", err=True)
