"""Comparisons of the healthy bearing with Figs. 8 and 9."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from dcrb_ros.settings.loaded_contacts import cage_speed
from dcrb_ros.validation.measures import load_zone, settling_time
from dcrb_ros.validation.report_row import PAPER, ReportRow, between, within
from dcrb_ros.validation.runs import JOINTS, PaperRun, PaperRuns

ROLLING_FORCE = 5e3
"""Normal force above which a roller is assumed to roll without sliding [N]."""
ABSOLUTE_SPIN, RELATIVE_SPIN = -328.1, -380.5
"""Roller spin in pure rolling at 124.8 rad/s, -omega_I r_I / (2 r_R), and relative to the cage [rad/s]; section 2.3.2 gives the latter."""


def healthy_rows(runs: PaperRuns) -> Iterator[ReportRow]:
    """Yield the comparisons for each joint."""
    for joint in JOINTS:
        healthy, cold = runs["healthy", joint], runs["cold start", joint]
        yield _cage(healthy)
        yield _spin(healthy)
        yield _settling(cold)
        yield _total_force(healthy)
        yield _largest_force(healthy)
        yield _zone(healthy)
        yield _cold_friction(cold)
        yield _steady_friction(healthy)
        yield _slip(healthy)
        yield energy_row(healthy, "", 0.01)


def _cage(run: PaperRun) -> ReportRow:
    most = 5e-4 if run.spec.joint == "revolute" else 1e-2
    orbit = "2 r_M" if run.spec.joint == "revolute" else "2 (r_I + r_R)"
    rolling = cage_speed(run.configuration, run.configuration.operating.speed)
    return run.row(
        "Cage speed, steady",
        "52.4 rad/s (section 2.3.2)",
        f"{run.mean_cage_speed:.3f} rad/s",
        f"omega_I r_I / {orbit} = {rolling:.3f} rad/s, {100.0 * most:g} %",
        within(run.mean_cage_speed, rolling, most),
    )


def _spin(run: PaperRun) -> ReportRow:
    loaded = run.inner_force[run.settled] > ROLLING_FORCE
    absolute, relative = (float(spin[run.settled][loaded].mean()) for spin in (run.spin, run.relative_spin))
    return run.row(
        "Roller spin in the load zone, relative to the cage and absolute",
        "-380.5 rad/s, - (section 2.3.2)",
        f"{relative:.1f}, {absolute:.1f} rad/s",
        f"{RELATIVE_SPIN}, {ABSOLUTE_SPIN} rad/s, 1.5 %",
        within(relative, RELATIVE_SPIN, 0.015) and within(absolute, ABSOLUTE_SPIN, 0.015),
    )


def _settling(run: PaperRun) -> ReportRow:
    settled = settling_time(run.time, run.spin.mean(axis=1), 0.02)
    quantity = "Settling time from a cold start, mean spin within 2 %"
    return between(PAPER, quantity, settled, 0.06, 0.13, "s", joint=run.spec.joint, paper="about 0.1 s (Fig. 8)")


def _total_force(run: PaperRun) -> ReportRow:
    force = run.inner_ring_force[run.settled]
    operating = run.configuration.operating
    expected = operating.load + run.configuration.bearing.inner_ring_mass * operating.gravity
    return run.row(
        "Total force on the inner ring, healthy",
        "about 100 kN (Fig. 9a)",
        f"{force.mean() / 1e3:.2f} +- {force.std() / 1e3:.2f} kN",
        f"{expected / 1e3:.2f} kN, 0.1 %; sd below 1 %",
        within(float(force.mean()), expected, 1e-3) and float(force.std()) < 0.01 * expected,
    )


def _largest_force(run: PaperRun) -> ReportRow:
    force, azimuth = run.inner_force[run.settled], run.azimuth[run.settled]
    largest, where = float(force.max()), float(round(np.degrees(azimuth.ravel()[force.argmax()]), 1))
    return run.row(
        "Largest roller force and its azimuth",
        "about 30 kN near 0 deg (Fig. 9a)",
        f"{largest / 1e3:.2f} kN at {where + 0.0:.1f} deg",
        "28.5-31.5 kN within 5 deg",
        28.5e3 <= largest <= 31.5e3 and abs(where) < 5.0,
    )


def _zone(run: PaperRun) -> ReportRow:
    zone = load_zone(run.azimuth[run.settled], run.inner_force[run.settled])
    return run.row(
        "Load zone (normal force above 50 N)",
        "-30..30 deg (Fig. 9a)",
        f"{zone.first:.1f}..{zone.last:.1f} deg",
        "26-34 deg on either side",
        26.0 <= -zone.first <= 34.0 and 26.0 <= zone.last <= 34.0,
    )


def _cone_excess(run: PaperRun) -> float:
    """Return the largest ratio of the friction force to its limit mu_s F_n [-]."""
    closed = run.inner_force > 1.0
    static: float = run.configuration.friction.static_coefficient
    return float((np.abs(run.friction[closed]) / run.inner_force[closed]).max()) / static


def _cold_friction(run: PaperRun) -> ReportRow:
    largest = float(np.abs(run.friction).max())
    return run.row(
        "Friction during the cold start",
        "up to about 1.5 kN (Fig. 9b)",
        f"{largest / 1e3:.2f} kN, {_cone_excess(run):.3f} mu_s F_n",
        "1.4-1.9 kN, at most 1.02 mu_s F_n",
        1.4e3 <= largest <= 1.9e3 and _cone_excess(run) <= 1.02,
    )


def _steady_friction(run: PaperRun) -> ReportRow:
    in_zone = np.abs(run.azimuth[run.settled]) < np.radians(20.0)
    friction = np.abs(run.friction[run.settled][in_zone])
    return run.row(
        "Friction in the load zone, steady",
        "up to about 1.5 kN (Fig. 9b); see below",
        f"median {np.median(friction):.0f} N, largest {friction.max():.0f} N",
        "at most 1.02 mu_s F_n; largest below 500 N",
        _cone_excess(run) <= 1.02 and float(friction.max()) < 500.0,
    )


def _slip(run: PaperRun) -> ReportRow:
    azimuth, slip = np.abs(run.azimuth[run.settled]), np.abs(run.slip[run.settled])
    inside, outside = float(slip[azimuth < np.radians(20.0)].mean()), float(slip[azimuth > np.radians(40.0)].mean())
    return run.row(
        "Mean slip inside and outside the load zone",
        "about 0, larger outside (Fig. 9c)",
        f"{inside:.1e}, {outside:.1e} m/s",
        "below 1e-3 m/s inside, more than 10 times that outside",
        inside < 1e-3 and outside > 10.0 * inside,
    )


def energy_row(run: PaperRun, name: str, most: float) -> ReportRow:
    """Compare the residual of the energy account over the work of shaft, load and the defect's law with the largest accepted [-]."""
    share = run.energy.residual / sum(abs(work) for work in (run.energy.drive, run.energy.load, run.energy.notch))
    return between(PAPER, f"Energy account{name}: residual over energy input", abs(share), -math.inf, most, joint=run.spec.joint)
