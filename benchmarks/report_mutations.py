"""Which rows of the report of ``dcrb validate`` notice a change of the benches: the table of docs/results/accuracy.md.

``python benchmarks/report_mutations.py`` changes parameters of the lubricated benches and of the dry one, one mutation after the other, and
lists the rows that hold without a change and fall short with it. The other chapters do not depend on these benches.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.validation.dry_bench import dry_bench_rows
from dcrb_ros.validation.oiled_bench import oiled_bench_rows
from dcrb_ros.validation.oiled_runs import oiled_specs, simulate_oiled
from dcrb_ros.validation.realism_rows import realism_rows
from dcrb_ros.validation.report_row import ReportRow
from dcrb_ros.validation.runs import paper_spec, simulate
from dcrb_ros.validation.surface_rows import surface_rows

MUTATIONS: dict[str, tuple[str, ...]] = {
    "pocket clearance x 5, restitution 0.5": ("cage.pocket_clearance=5e-4", "cage.restitution=0.5"),
    "damping of the contacts x 3": ("contact.loss_time=3e-5",),
    "friction at bars and lands x 2": ("cage.friction_coefficient=0.1",),
    "viscosity x 2": ("lubrication.lubricant=custom", "lubrication.viscosity_40=200.0", "lubrication.viscosity_100=22.0"),
    "temperature 70 instead of 60 °C": ("lubrication.temperature=70.0",),
    "layer 2 instead of 5 µm": ("lubrication.layer=2e-6",),
    "limiting friction x 1.5": ("lubrication.limiting_friction=0.09",),
    "no rolling resistance": ("lubrication.rolling_resistance=false",),
    "no squeeze film": ("lubrication.squeeze=false",),
    "roughness x 2": ("lubrication.roughness=5.6e-7",),
    "stiffness of steel x 1.2": ("bearing.youngs_modulus=2.49e11",),
    "spread of the rollers' diameters x 5": ("surfaces.roller_spread=3e-6",),
    "waviness x 3": ("surfaces.waviness=3e-7",),
    "no axle box": ("housing.box_mass=0.0",),
    "clearance 0.28 instead of 0.07 mm": ("bearing.inner_raceway_radius=0.07886", "bearing.outer_raceway_radius=0.10914"),
    "load 80 instead of 100 kN": ("operating.load=80000.0",),
    "speed + 2 %": ("operating.speed=128.18",),
}
"""Settings of each mutation."""
OIL_ONLY = ("lubrication.", "surfaces.", "housing.")
"""Groups without effect on the dry bench."""


def comparisons(settings: tuple[str, ...]) -> Iterator[ReportRow]:
    """Yield the rows that depend on the benches, with changed parameters."""
    runs = {spec.name: simulate_oiled(spec, settings) for spec in oiled_specs()}
    yield from oiled_bench_rows(runs)
    yield from surface_rows(runs)
    yield from realism_rows(runs)
    of_dry_bench = tuple(setting for setting in settings if not setting.startswith(OIL_ONLY))
    dry = simulate(paper_spec("healthy", "pocket", 2.0, of_dry_bench, state_rate=3000))
    yield from (replace(row, chapter="The paper") for row in dry_bench_rows(dry))


def main() -> None:
    """Print the table."""
    names = sys.argv[1:] or list(MUTATIONS)
    if unknown := sorted(set(names) - set(MUTATIONS)):
        sys.exit(f"there is no mutation '{unknown[0]}' (known: {', '.join(MUTATIONS)})")
    held = {(row.chapter, row.quantity, row.joint) for row in comparisons(()) if row.holds}
    print("| mutation | rows that notice | which |\n|---|---|---|")
    for name in names:
        try:
            rows = [row for row in comparisons(MUTATIONS[name]) if (row.chapter, row.quantity, row.joint) in held]
        except Refusal as refusal:
            print(f"| {name} | refused | {refusal} |", flush=True)
            continue
        short = [f"{row.quantity} ({row.found})" for row in rows if not row.holds]
        print(f"| {name} | {len(short)} of {len(rows)} | {'; '.join(short) or 'none'} |", flush=True)


if __name__ == "__main__":
    main()
