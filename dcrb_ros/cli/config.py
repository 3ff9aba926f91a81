"""`dcrb config`: list, print and check configurations; print the parameter table."""

from __future__ import annotations

import typer

from dcrb_ros.cli.options import Config, Settings

app = typer.Typer(no_args_is_help=True, help="List, print and check configurations of the bench.")


@app.command("list")
def list_() -> None:
    """List the shipped configurations, each with a one-line description.

    Example: dcrb config list
    """
    from dcrb_ros.settings.files import shipped_configurations

    for name, path in shipped_configurations().items():
        remark = path.read_text(encoding="utf-8").splitlines()[0].lstrip("# ")
        print(f"{name:20s} {remark}")


@app.command()
def show(config: Config, settings: Settings = None) -> None:
    """Print a configuration as YAML with all parameters, defaults included.

    Example: dcrb config show healthy --set operating.speed=100.0
    """
    from dcrb_ros.settings.files import load_configuration, to_yaml

    print(to_yaml(load_configuration(config, settings or ())), end="")


@app.command()
def check(config: Config, settings: Settings = None) -> None:
    """Check a configuration; if it is invalid, print the reason and exit with status 2.

    Example: dcrb config check my_bearing.yaml
    """
    from dcrb_ros.settings.files import load_configuration

    load_configuration(config, settings or ())
    print(f"{config} is valid")


@app.command()
def docs() -> None:
    """Print the table of all parameters in Markdown: key, unit, default, range and meaning.

    Example: dcrb config docs > parameters.md
    """
    from dcrb_ros.settings.files import parameter_table

    print(parameter_table())
