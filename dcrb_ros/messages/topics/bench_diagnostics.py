"""The state of the nodes themselves."""

from __future__ import annotations

from dcrb_ros.messages.cdr import DIAGNOSTICS
from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topic import Topic

BENCH_DIAGNOSTICS = Topic(
    "/diagnostics",
    DIAGNOSTICS,
    "state of the simulator, 1 Hz: paused or running, time scale, real-time factor, late blocks, rejected commands, recorder, other "
    "publishers, residual of the energy account of a bench, film, Lambda and friction power of a lubricated bearing, and temperatures and "
    "heat with `thermal.law: network`; stamped with the wall clock, or with simulated time if `use_sim_time` is set",
    decode=decode_diagnostics,
)
