"""The normal force over a step: strikes on a raceway keep their energy, and a contact that lasts has its right frequency."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.contacts.force_line import crosses, crossing_line, elastic, lasting_line
from dcrb_ros.core.jit import loop, piece
from dcrb_ros.core.laws.calls import film_offset
from dcrb_ros.core.laws.johnson import johnson_force
from dcrb_ros.core.laws.power import power_force
from dcrb_ros.core.laws.site import NoMemory
from dcrb_ros.core.laws.squeeze import squeeze_impulse
from dcrb_ros.core.payload import Payload
from dcrb_ros.settings.configuration import Configuration

pytestmark = [pytest.mark.kernel, pytest.mark.slow]

speeds, phases = st.floats(2e-3, 1.0), st.floats(0.0, 1.0)


@piece
def raceway_line(
    payload: Payload, middle: float, closing: float, before: float, last: float, mobility: float
) -> tuple[float, float, float, float, float]:
    """Return the line of a contact, be it closed all the step or not."""
    law, memory = payload.normal_law, NoMemory()
    if crosses(law, payload.outer, middle, closing, before, payload.step):
        return crossing_line(payload, memory, payload.outer, middle, closing, before, 0.0, last, mobility)
    force, stiffness = elastic(law, memory, middle, payload.outer)
    return lasting_line(payload, memory, payload.outer, middle, force, stiffness, closing, before, 0.0)


@loop
def line(payload: Payload, middle: float, speed: float) -> tuple[float, float, float, float, float]:
    """Return the line of a contact at a steady speed of penetration."""
    return raceway_line(payload, middle, speed, speed, 0.0, 0.0)


@loop
def fly(payload: Payload, place: float, speed: float, steps: int) -> tuple[float, float]:
    """Return the speed of a roller into a raceway, and the impulse that it took, ``steps`` after it was ``place`` deep in it."""
    mobility, last, change, impulse = 0.5 * payload.step / payload.roller_mass, 0.0, 0.0, 0.0
    for _ in range(steps):
        middle = place + 0.5 * payload.step * speed
        push, give, known, damping, expected = raceway_line(payload, middle, speed + 0.5 * change, speed, last, mobility)
        mean = (speed - mobility * push) / (1.0 + mobility * give)
        last, change = known + damping * (mean - expected), 2.0 * (mean - speed)
        impulse += payload.step * (push + give * mean)
        speed, place = 2.0 * mean - speed, middle + 0.5 * payload.step * (2.0 * mean - speed)
    return speed, impulse


@loop
def approach(payload: Payload, gap: float, speed: float, least: float) -> tuple[float, float]:
    """Return speed [m/s] and gap [m] of a roller that has come as close to a raceway as ``least`` [m], or has stopped before."""
    mobility, last, change, place, begin = 0.5 * payload.step / payload.roller_mass, 0.0, 0.0, -gap, (speed, gap)
    while -place > least and speed > 1e-3:
        begin = (speed, -place)
        middle = place + 0.5 * payload.step * speed
        push, give, known, damping, expected = raceway_line(payload, middle, speed + 0.5 * change, speed, last, mobility)
        mean = (speed - mobility * push) / (1.0 + mobility * give)
        last, change = known + damping * (mean - expected), 2.0 * (mean - speed)
        speed, place = 2.0 * mean - speed, middle + 0.5 * payload.step * (2.0 * mean - speed)
    return begin


def bearing(**contact: object) -> Payload:
    """Return the default bearing, its contacts without loss unless ``contact`` says otherwise."""
    return build_payload(Configuration.model_validate({"contact": {"loss_time": 0.0, **contact}}))


@pytest.mark.parametrize("law", ["johnson", "power"])
@given(speed=speeds, phase=phases)
def test_strike_without_loss_gives_back_what_it_took(law: str, speed: float, phase: float) -> None:
    # At the default step it lasts four to six, whatever its phase.
    payload = bearing(law=law)
    after, impulse = fly(payload, -phase * payload.step * speed, speed, 40)
    assert after**2 == pytest.approx(speed**2, rel=8e-3)
    assert impulse == pytest.approx(payload.roller_mass * (speed - after), rel=1e-9)


@pytest.mark.parametrize("loss", [{"loss_time": 2.5e-6}, {"damping": 2e3}], ids=["of the stiffness", "constant"])
@given(speed=st.floats(1e-2, 0.5), phase=phases)
def test_strike_with_loss_leaves_at_the_laws_speed(loss: dict[str, float], speed: float, phase: float) -> None:
    payload = bearing(**loss)

    def law(_: float, state: list[float]) -> list[float]:
        depth, rate = state
        force, stiffness = johnson_force(payload.normal_law, NoMemory(), depth, payload.outer) if depth > 0.0 else (0.0, 0.0)
        damping = stiffness * payload.loss_time + (payload.contact_damping if depth > 0.0 else 0.0)
        return [rate, -max(force + damping * rate, 0.0) / payload.roller_mass]

    exact = solve_ivp(law, (0.0, 1e-4), [0.0, speed], max_step=2e-7, rtol=1e-9, atol=1e-14).y[1, -1]
    after = fly(payload, -phase * payload.step * speed, speed, 40)[0]
    assert after == pytest.approx(exact, rel=0.015)


@loop
def line_over_floor(payload: Payload, middle: float, closing: float, sink: float, crossing: bool) -> tuple[float, float]:
    """Return push and give of a contact that closes at a speed against a floor that falls away with ``sink`` [m/s]."""
    if crossing:
        found = crossing_line(payload, NoMemory(), payload.outer, middle, closing, closing, sink, 0.0, 0.0)
    else:
        force, stiffness = elastic(payload.normal_law, NoMemory(), middle, payload.outer)
        found = lasting_line(payload, NoMemory(), payload.outer, middle, force, stiffness, closing, closing, sink)
    return found[0], found[1]


@given(middle=st.floats(-1e-6, 1e-5), closing=speeds, sink=st.floats(-0.5, 0.5), crossing=st.booleans())
def test_a_falling_floor_shifts_the_approach(middle: float, closing: float, sink: float, crossing: bool) -> None:
    # The line is over the approach to the ring; the floor's fall is no penetration.
    payload = bearing(loss_time=1e-6)
    push, give = line_over_floor(payload, middle, closing, sink, crossing)
    still_push, still_give = line_over_floor(payload, middle, closing, 0.0, crossing)
    assert give == still_give
    assert push + give * (closing + sink) == pytest.approx(still_push + still_give * closing, rel=1e-9, abs=1e-9)


@given(depth=st.floats(5e-6, 3e-5), johnson=st.booleans())
def test_lasting_contact_swings_at_its_own_frequency(depth: float, johnson: bool) -> None:
    # Small swings about a depth, 9 steps a period: leapfrog alone would be 2 % too fast, the mean over a straight way 4 % too slow.
    payload = bearing(law="johnson" if johnson else "power")
    weight, stiffness = (johnson_force if johnson else power_force)(payload.normal_law, NoMemory(), depth, payload.outer)
    places, place, speed, swing = [], depth, 1e-9 * math.sqrt(stiffness / payload.roller_mass), payload.step
    for _ in range(200):
        # The weight holds it in: a kick to the speed before the step, half taken back for the way.
        kick = 0.5 * swing * weight / payload.roller_mass
        push, give, *_ = line(payload, place + 0.5 * swing * speed, speed)
        mean = (speed + kick - 0.5 * swing / payload.roller_mass * push) / (1.0 + 0.5 * swing / payload.roller_mass * give)
        place, speed = place + 0.5 * swing * speed + 0.5 * swing * (2.0 * mean - speed), 2.0 * mean - speed
        places.append(place - depth)
    crossings = [n + places[n] / (places[n] - places[n + 1]) for n in range(199) if places[n] < 0.0 <= places[n + 1]]
    period = (crossings[-1] - crossings[0]) / (len(crossings) - 1) * swing
    assert period == pytest.approx(2.0 * math.pi * math.sqrt(payload.roller_mass / stiffness), rel=4e-3)


@given(gap=st.floats(1e-9, 1e-3), speed=st.floats(-1.0, 1.0))
def test_open_contact_is_without_force(gap: float, speed: float) -> None:
    payload = bearing()
    reached = max(-gap - 0.5 * payload.step * speed, -gap + 0.5 * payload.step * speed)
    push, give, known, damping, _ = line(payload, -gap, speed)
    if reached <= 0.0:
        assert (push, give, known, damping) == (0.0, 0.0, 0.0, 0.0)
    else:
        assert known >= 0.0


OIL = {"law": "film", "lubricant": "vg100", "temperature": 70.0, "layer": 20e-6}


@loop
def changes_side(payload: Payload, begin: float, end: float) -> bool:
    """Return whether a contact closes or opens within a step from one penetration to another [m]."""
    speed = (end - begin) / payload.step
    return crosses(payload.normal_law, payload.outer, 0.5 * (begin + end), speed, speed, payload.step)


@pytest.mark.parametrize("lubrication", [{}, OIL], ids=["dry", "oil"])
def test_a_contact_crosses_where_it_meets_its_film(lubrication: dict[str, object]) -> None:
    payload = build_payload(Configuration.model_validate({"lubrication": lubrication}))
    film = film_offset(payload.outer.film)
    assert (film > 1e-7) == bool(lubrication)
    apart, touching, deep = -film - 1e-6, -film + 1e-8, film + 1e-6
    assert changes_side(payload, apart, touching)
    assert changes_side(payload, touching, apart)
    assert changes_side(payload, apart, deep)
    assert not changes_side(payload, touching, deep)
    assert not changes_side(payload, deep, touching)
    assert not changes_side(payload, apart, apart - 1e-6)


@pytest.mark.parametrize("steps_per_sample", [2, 98])
@given(speed=st.floats(0.03, 0.3), phase=phases)
def test_a_layer_takes_its_impulse_whatever_the_step(steps_per_sample: int, speed: float, phase: float) -> None:
    # At standstill there is no wedge; the layer takes 0.169 m/s down to 1 um: docs/explanation/lubrication.md, "Squeeze film".
    step = 1.0 / (51200.0 * steps_per_sample)
    payload = build_payload(Configuration.model_validate({"lubrication": OIL, "operating": {"speed": 0.0}, "simulation": {"step": step}}))
    film = payload.outer.film
    whole = squeeze_impulse(1e-6, film.squeeze, film.floor, film.layer) / payload.roller_mass
    assert whole == pytest.approx(0.169, abs=6e-4)
    left, gap = approach(payload, film.layer + phase * step * speed, speed, 1e-6)
    taken = squeeze_impulse(gap, film.squeeze, film.floor, film.layer) / payload.roller_mass
    assert speed - left == pytest.approx(taken, abs=0.01 * whole)
