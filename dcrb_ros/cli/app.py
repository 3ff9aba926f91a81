"""The command `dcrb`: one module per command; each imports its dependencies when it is called, so that `dcrb --help` is fast."""

from __future__ import annotations

import sys
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
from dcrb_ros.cli.literal_help import Commands, LiteralGroup
from dcrb_ros.runtime.exit_status import exit_status
from dcrb_ros.runtime.version import __version__


class Program(LiteralGroup):
    """The commands of the program. Ctrl-C in one of them reaches `exit_status`; some releases of typer make it a plain status."""

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise typer.Abort from None


app = Commands(cls=Program, pretty_exceptions_enable=False)
app.command("simulate")(simulate.simulate)
app.command("bench")(bench.bench)
app.command("replay")(replay.replay)
app.command("detect")(detect.detect)
app.command("score")(score.score)
app.command("view")(view.view)
app.command("plot")(plot.plot)
app.command("info")(info.info)
app.command("recover")(recover.recover)
app.command("export")(exchange.export)
app.command("import")(exchange.import_)
app.command("calibrate")(calibrate.calibrate)
app.command("compare")(calibrate.compare)
app.command("sweep")(sweep.sweep)
app.command("shards")(shards.shards)
app.command("collect")(collect.collect)
app.command("validate")(validate.validate)
app.command("cache")(cache.cache)
app.add_typer(exam.app, name="exam")
app.add_typer(config.app, name="config")


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
