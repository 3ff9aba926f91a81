"""The command `dcrb`: one module per command; each imports its dependencies when it is called, so that `dcrb --help` is fast."""

from __future__ import annotations

import signal
import sys

import typer

from dcrb_ros.cli import bench, config, detect, exchange, info, plot, recover, replay, score, simulate, sweep, validate, view
from dcrb_ros.runtime.exit_status import exit_status
from dcrb_ros.runtime.signals import TERMINATION
from dcrb_ros.runtime.version import __version__

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False)
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
app.command("sweep")(sweep.sweep)
app.command("validate")(validate.validate)
app.add_typer(config.app, name="config")


def _version(asked: bool) -> None:
    if asked:
        print(f"dcrb_ros {__version__}")
        raise typer.Exit


@app.callback()
def dcrb(version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Print the version and exit.")) -> None:
    """A simulated double-row cylindrical roller bearing with an accelerometer, for developing and testing fault detectors."""


def main() -> None:
    """Run the command line."""
    # Every termination signal is handled like Ctrl-C, so that child processes are terminated too.
    for number in TERMINATION:
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)
    sys.exit(exit_status("dcrb", lambda: app(standalone_mode=False)))
