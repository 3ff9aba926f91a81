"""`dcrb config`: the shipped configurations, a merged one, a check, the parameter table."""

from __future__ import annotations

from typing import Annotated

import typer

app = typer.Typer(no_args_is_help=True, help="The configurations of the bench.")

Source = Annotated[str, typer.Argument(help="A YAML file or a shipped name.")]
Settings = Annotated[list[str] | None, typer.Option("--set", help="KEY=VALUE on top.")]


@app.command("list")
def list_() -> None:
    """List the shipped configurations."""
    from dcrb_ros.settings.files import shipped_configurations

    for name, path in shipped_configurations().items():
        remark = path.read_text(encoding="utf-8").splitlines()[0].lstrip("# ")
        print(f"{name:20s} {remark}")


@app.command()
def show(config: Source, settings: Settings = None) -> None:
    """Print a configuration with every parameter in it."""
    from dcrb_ros.settings.files import load_configuration, to_yaml

    print(to_yaml(load_configuration(config, settings or ())), end="")


@app.command()
def check(config: Source, settings: Settings = None) -> None:
    """Check a configuration; exit status 2 and the reason where it is refused."""
    from dcrb_ros.settings.files import load_configuration

    load_configuration(config, settings or ())
    print(f"{config} is valid")


@app.command()
def docs() -> None:
    """Print the table of all parameters in Markdown."""
    from dcrb_ros.settings.files import parameter_table

    print(parameter_table())
