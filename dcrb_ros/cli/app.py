"""The command `dcrb`: one module per command; each imports its dependencies when it is called, so that `dcrb --help` is fast."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from typing import Any

import typer

from dcrb_ros.cli import (
    bench,
    cache,
    calibrate,
    collect,
    config,
    detect,
    exam,
    exchange,
    info,
    plot,
    recover,
    replay,
    score,
    shards,
    simulate,
    sweep,
    validate,
    view,
)
from dcrb_ros.cli.commands import Commands, LiteralGroup
from dcrb_ros.runtime.exit_status import exit_status
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.refusal import AlteredSamples


class Program(LiteralGroup):
    """The commands of the program. Ctrl-C in one of them reaches `exit_status`; some releases of typer make it a plain status."""

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        with warnings.catch_warnings():
            warnings.filterwarnings("always", category=AlteredSamples)
            warnings.showwarning = _printing_altered(warnings.showwarning)
            try:
                return super().invoke(ctx)
            except KeyboardInterrupt:
                raise typer.Abort from None


def _printing_altered(others: Callable[..., None]) -> Callable[..., None]:
    """Return a function that prints each sentence on altered samples once, and hands on every other warning."""
    printed = set[str]()

    def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if not issubclass(category, AlteredSamples):
            others(message, category, *place, **more)
        elif str(message) not in printed:
            printed.add(str(message))
            typer.echo(f"warning: {message}", err=True)

    return show


app = Commands(cls=Program, pretty_exceptions_enable=False)
SIMULATE, RECORDINGS, DETECT = "Simulate", "Recordings", "Detect and evaluate"
DATA_SETS, CONFIGURATION = "Data sets", "Configuration"
"""Purposes by which the help groups the commands."""

app.command("simulate", rich_help_panel=SIMULATE)(simulate.simulate)
app.command("bench", rich_help_panel=SIMULATE)(bench.bench)
app.command("validate", rich_help_panel=SIMULATE)(validate.validate)
app.command("view", rich_help_panel=RECORDINGS)(view.view)
app.command("plot", rich_help_panel=RECORDINGS)(plot.plot)
app.command("info", rich_help_panel=RECORDINGS)(info.info)
app.command("compare", rich_help_panel=RECORDINGS)(calibrate.compare)
app.command("replay", rich_help_panel=RECORDINGS)(replay.replay)
app.command("import", rich_help_panel=RECORDINGS, epilog="Many files with known faults, as a data set: dcrb collect.")(exchange.import_)
app.command("export", rich_help_panel=RECORDINGS)(exchange.export)
app.command("recover", rich_help_panel=RECORDINGS)(recover.recover)
app.command("detect", rich_help_panel=DETECT)(detect.detect)
app.command("score", rich_help_panel=DETECT, epilog="Sealed exams and leaderboards: dcrb exam.")(score.score)
app.add_typer(exam.app, name="exam", rich_help_panel=DETECT)
app.command("sweep", rich_help_panel=DATA_SETS)(sweep.sweep)
app.command("collect", rich_help_panel=DATA_SETS, epilog="A single file, as a recording: dcrb import.")(collect.collect)
app.command("shards", rich_help_panel=DATA_SETS)(shards.shards)
app.add_typer(config.app, name="config", rich_help_panel=CONFIGURATION)
app.command("calibrate", rich_help_panel=CONFIGURATION)(calibrate.calibrate)
app.command("cache", rich_help_panel=CONFIGURATION)(cache.cache)
exam.app.command("run", help="Evaluate a fault detector by an exam: the same as dcrb score.\n\nExample: dcrb exam run smoke")(score.score)


def _version(asked: bool) -> None:
    if asked:
        print(f"dcrb_ros {__version__}")
        raise typer.Exit


@app.callback()
def dcrb(version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Print the version and exit.")) -> None:
    """A simulated double-row cylindrical roller bearing with an accelerometer, for developing and testing fault detectors."""


def run() -> int:
    """Run the command line and return the exit status; `dcrb_ros.cli.program` handles the signals."""
    return exit_status("dcrb", lambda: app(prog_name="dcrb", standalone_mode=False))


def main() -> None:
    """Run the command line, and exit."""
    sys.exit(run())
