"""`dcrb config`: list, print, check and make configurations; print the parameters."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dcrb_ros.cli.commands import Commands
from dcrb_ros.cli.options import Config, Force, Settings
from dcrb_ros.cli.output_file import check_file
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.writing import write_whole

if TYPE_CHECKING:
    from dcrb_ros.schema.parameter_field import ParameterField
    from dcrb_ros.settings.configuration import Configuration

app = Commands(help="List, print, check and make configurations of the bench.")
MOST_ERRORS = 20
"""Errors that `dcrb config check` prints."""
DETECTOR, VEHICLE_DETECTOR = "fault_detector", "vehicle_detector"
"""The groups that stand for the parameters of the fault detector and of the comparing detector."""


@app.command("list")
def list_() -> None:
    """List the shipped configurations, each with a one-line description.

    Example: dcrb config list
    """
    from dcrb_ros.settings.shipped import shipped

    for name, path in shipped("configuration").items():
        remark = path.read_text(encoding="utf-8").splitlines()[0].lstrip("# ")
        print(f"{name:20s} {remark}")


@app.command()
def show(config: Config, settings: Settings = None) -> None:
    """Print a configuration as YAML with all parameters, defaults included, as it runs; units are comments.

    The output is a ROS parameter file, for dcrb and for --params-file.

    Example: dcrb config show healthy --set operating.speed=100.0
    """
    from dcrb_ros.settings.files import load_configuration, to_described_yaml

    print(to_described_yaml(load_configuration(config, settings or ())), end="")


@app.command()
def check(config: Config, settings: Settings = None) -> None:
    """Check a configuration: print the derived values, or up to 20 errors and exit with status 2.

    Masses and inertias of the default bearing in a bearing of other dimensions give warnings, and so do negative and very small loads,
    and a defect that is a notch where the surfaces could have a spall. The start of a run without a scenario is checked, too.

    Example: dcrb config check my_bearing.yaml
    """
    from dcrb_ros.bearing.data_sheet import data_sheet, implausible_loads, kept_defaults
    from dcrb_ros.bearing.plausibility import implausible_notches
    from dcrb_ros.runtime.exit_status import print_error
    from dcrb_ros.settings.configuration import Configuration
    from dcrb_ros.settings.files import checked, layers

    parameters, misplaced = layers(config, settings or ())
    # A file without parameters has defaults only, which are sound.
    configuration, found = checked(parameters, Configuration)
    wrong = [*misplaced, *found]
    if configuration is not None and not wrong:
        wrong = list(_refused_at_start(configuration))
    for sentence in wrong[:MOST_ERRORS]:
        print_error("dcrb", f"{config}: {sentence}")
    if (others := len(wrong) - MOST_ERRORS) > 0:
        print_error("dcrb", f"{config}: {others} more {'errors' if others > 1 else 'error'}; correct these first")
    if configuration is None or wrong:
        raise typer.Exit(2)
    print(f"{config} is valid")
    for name, text in data_sheet(configuration).items():
        print(f"  {name:20s} {text}")
    for sentence in (*kept_defaults(configuration.bearing), *implausible_loads(configuration), *implausible_notches(configuration)):
        print_error("dcrb", f"warning: {sentence}")


def _refused_at_start(configuration: Configuration) -> Iterator[str]:
    """Yield why sensor and bearing of a valid configuration could not start."""
    from dcrb_ros.bearing.payload import build_payload
    from dcrb_ros.measurement.sensor import Sensor
    from dcrb_ros.simulation.heating import Heating

    for begin in (
        lambda: Sensor(configuration.measurement),
        lambda: Heating(configuration).begin(configuration, build_payload(configuration)),
    ):
        try:
            begin()
        except Refusal as refusal:
            yield str(refusal)


@app.command()
def new(
    context: typer.Context,
    output: Annotated[Path, typer.Option("-o", "--output", help="New YAML file.")],
    inner_raceway: Annotated[float, typer.Option("-F", "--inner-raceway", help="Diameter of the inner raceway [mm], F in catalogues.")],
    rollers: Annotated[int, typer.Option("-Z", "--rollers", help="Rollers in each row [-].")],
    roller_diameter: Annotated[float, typer.Option("--roller-diameter", help="Diameter of the rollers [mm].")],
    roller_length: Annotated[float, typer.Option("--roller-length", help="Effective length of the rollers, without chamfers [mm].")],
    rpm: Annotated[float, typer.Option(help="Speed of the inner ring [1/min].")],
    outer_raceway: Annotated[
        float | None, typer.Option("-E", "--outer-raceway", help="Diameter of the outer raceway [mm], E in catalogues; checked.")
    ] = None,
    rows: Annotated[int, typer.Option(help="Rows of rollers, 1 or 2.")] = 1,
    bore: Annotated[float | None, typer.Option("-d", "--bore", help="Bore [mm]. Default: estimated.")] = None,
    outside: Annotated[float | None, typer.Option("-D", "--outside", help="Outside diameter [mm]. Default: estimated.")] = None,
    width: Annotated[float | None, typer.Option("-B", "--width", help="Width [mm]. Default: estimated.")] = None,
    clearance: Annotated[
        float | None, typer.Option(help="Radial internal clearance [um]. Default: middle of the normal group of ISO 5753-1.")
    ] = None,
    load: Annotated[float | None, typer.Option(help="Radial load [N]. Default: a tenth of the load rating.")] = None,
    contact_angle: Annotated[
        float, typer.Option(help="Contact angle of a tapered or spherical bearing [degrees]; diameters are those at the rollers' middle.")
    ] = 0.0,
    force: Force = False,
) -> None:
    """Write the configuration of a roller bearing from catalogue data, and print the values that were filled in.

    Example: dcrb config new -o nj2210.yaml -F 59.5 -E 81.5 -Z 16 --roller-diameter 11 --roller-length 16 --rpm 1500
    """
    from dcrb_ros.bearing.catalogue import CatalogueBearing, configuration_of, described_yaml

    check_file("-o", output, (".yaml", ".yml"), force=force)
    bearing = CatalogueBearing(**{field.name: context.params[field.name] for field in fields(CatalogueBearing)})
    parameters, filled = configuration_of(bearing)
    kind = f"Roller bearing with a contact angle of {contact_angle:g} degrees" if contact_angle else "Cylindrical roller bearing"
    title = f"{kind}, {rows} x {rollers} rollers of {roller_diameter:g} x {roller_length:g} mm, at {rpm:g} rpm."
    write_whole(output, described_yaml(parameters, filled, title))
    print(f"{output}: the comments say where these values come from; replace them by those of a drawing")
    for entry in filled:
        print(f"  {entry.key:28s} {entry.value:<12.6g} {entry.source}")
    print(f"next: dcrb config check {shlex.quote(str(output))}")


Group = Annotated[
    str,
    typer.Argument(
        help="Group of parameters, such as bearing or faults.outer_1, a single parameter, a group of a vehicle, such as track or axle_1, "
        f"{DETECTOR} or {VEHICLE_DETECTOR}. Default: all of a bench."
    ),
]


@app.command()
def docs(group: Group = "") -> None:
    """Print the parameters of a group as a table, or all of a bench in Markdown: key, unit, default, range and meaning.

    Example: dcrb config docs bearing
    """
    from dcrb_ros.settings.documentation import parameter_table

    if not group:
        print(parameter_table())
        return
    from rich.table import Table

    from dcrb_ros.runtime.terminal import console

    table = Table()
    for head in ("parameter", "default", "range", "unit", "meaning"):
        table.add_column(head, no_wrap=head == "parameter", overflow="fold")
    for field in _below(group):
        default = f"{field.default:.6g}" if isinstance(field.default, float) else str(field.default)
        span = ", ".join(field.choices) or " .. ".join(field.limits)
        table.add_row(field.key, default, span, field.unit.removeprefix("-"), field.description)
    console().print(table)


def _below(group: str) -> list[ParameterField]:
    """Return the parameters of a group, or the one with this key; refuse a group that does not exist."""
    from dcrb_ros.cli.vehicle_parameters import vehicle_parameters
    from dcrb_ros.diagnosis.parameters import DetectorParameters
    from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
    from dcrb_ros.schema.refusal import nearest
    from dcrb_ros.settings.files import fields_by_key

    fields = {**fields_by_key(), **fields_by_key(vehicle_parameters())}
    for name, model in ((DETECTOR, DetectorParameters), (VEHICLE_DETECTOR, VehicleDetectorParameters)):
        fields |= {f"{name}.{key}": field for key, field in fields_by_key(model).items()}
    matching = [field for key, field in fields.items() if f"{key}.".startswith(f"{group}.")]
    if not matching:
        groups = list(dict.fromkeys(key.partition(".")[0] for key in fields))
        raise Refusal(f"there is no group of parameters '{group}': give one of {', '.join(groups)}{nearest(group, [*groups, *fields])}")
    return matching
