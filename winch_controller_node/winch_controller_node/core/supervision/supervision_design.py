"""What a tick is supervised by: parameters, load and constants, as the core has them (`heave_core`, supervise.cpp)."""

from __future__ import annotations

from typing import Any

from heave_core.modes_table import UNIT_PAST
from heave_node.interface.codes import WinchFault
from heave_node.winch.fault_latch import is_automatic

from winch_controller_node.beliefs.beliefs import CAUTIOUS
from winch_controller_node.core.estimation.loop_tick import TENSION_MEMORY
from winch_controller_node.core.estimation.sense_design import SENSOR
from winch_controller_node.core.supervision.guard_checks import PEAK, SIGNIFICANT, SLOW_MEAN_FACTOR
from winch_controller_node.core.supervision.landing import (
    LEAST_AUTHORITY,
    LEAST_RATE,
    MEAN_ERROR,
    HangingLoad,
)
from winch_controller_node.core.supervision.modes import MODES, WAIT, Mode
from winch_controller_node.core.supervision.watch.load_watch import QUIET_TIME
from winch_controller_node.design.design import ControllerDesign

REQUIRED_SENSORS = {
    Mode.CONSTANT_TENSION: ("load_cell", "encoder"),
    Mode.MANUAL: ("encoder",),
}
"""Sensors without which a mode cannot go on; all others need MRU and encoder."""

OTHERS = ("mru", "encoder")
"""Sensors that those need."""

HANGING_SHARES = (0.7, 1.3)
"""A unit hangs whose cable carries on average a share of its weight between these, and that has not landed."""

LEAST_AVERAGED = 1e-3
"""Share of the memory of a mean tension from which on it has an error."""

LONGEST_AGE = 6.0
"""Age of a depth reading up to which the estimate of its time is kept [s]: the largest latency, 5 s, and a second."""

SETTLED_AT_REST = 0.01
"""Swing of the unit at which a fade-out may end in calm water [m]; a sea adds its own, up to what a law can settle."""

BLIND_LIMIT = 900.0
"""Longest time for which the unit is damped by the depth sensor alone, until the brake goes on [s]."""

LONGEST_WAIT = 2.0
"""Time until which compensation waits for waves, over `modes.settling_time`: in calm water none come."""

PEAK_OVER_SIGNIFICANT = PEAK / SIGNIFICANT
"""Peak over significant amplitude."""

TENSION_PEAK = 2.7
"""Peak amplitude over standard deviation of forty waves, sqrt(2 ln 40): those of five minutes or more."""

TENSION_LEFT = 0.1
"""Share of a locked winch's tension that is left where the winch follows the whole sea: the cable has inertia too."""

TENSION_HOLD = 300.0
"""A highest tension that was once too low must be enough for so long before compensation keeps it again [s]."""

LEAST_OFF = 3.0
"""Difference of depth sensor and payout that is never too large [m]: of tide, draught and trim."""

HELD_TIME, REPORTED_AGAIN = 5.0, 60.0
"""Limited authority is reported once it has lasted for the first time [s], and again after the second; its end, once
that has lasted for the first time.
"""


def required_sensors(mode: Mode) -> tuple[str, ...]:
    """Return the sensors that a `mode` requires."""
    return REQUIRED_SENSORS.get(mode, OTHERS)


def supervision_design(design: ControllerDesign, load: HangingLoad) -> dict[str, Any]:
    """Return the values of the core's SupervisionDesign, of a `design` and its `load`.

    Raises ValueError for a tick too short for the heaves that are kept.
    """
    parameters, limits, dt = design.parameters, design.limits, design.tick_period
    past = 1 + round(LONGEST_AGE / dt)
    if past > UNIT_PAST:
        raise ValueError(f"tick_period = {dt:g} s: {past} ticks of {LONGEST_AGE:g} s are kept, {UNIT_PAST} fit")
    cable = design.cable
    # half of the cable's own weight stretches it as well
    pull = 0.5 * (cable.static_tension + design.unit_weight)
    return {
        "tick_period": dt,
        "past": past,
        "required": tuple(sum(1 << SENSOR[name] for name in required_sensors(mode)) for mode in MODES),
        "command_timeout": WinchFault.COMMAND_TIMEOUT,
        "emergency_stop": WinchFault.EMERGENCY_STOP,
        "automatic": sum(1 << fault for fault in WinchFault if is_automatic(fault)),
        "cautious": CAUTIOUS,
        "quiet_time": QUIET_TIME,
        "least_rate": LEAST_RATE,
        "least_authority": LEAST_AUTHORITY,
        "tension_memory": TENSION_MEMORY,
        "least_averaged": LEAST_AVERAGED,
        "mean_error": MEAN_ERROR,
        "cable_weight": load.cable_weight,
        "more": parameters.length - design.length,
        "hangs_least": HANGING_SHARES[0],
        "hangs_most": HANGING_SHARES[1],
        "hanging": parameters.tension.hanging,
        "length": parameters.length,
        "tip_height": parameters.boom_tip_height,
        "payout_tolerance": parameters.health.payout_tolerance,
        "stretch": pull / (cable.stiffness * design.length),
        "least_off": LEAST_OFF,
        "longest_wait": LONGEST_WAIT * parameters.modes.settling_time,
        "peak": PEAK,
        "peak_ratio": PEAK_OVER_SIGNIFICANT,
        "peak_use": parameters.entry.peak_use,
        "payout_minimum": limits.payout_minimum,
        "payout_maximum": limits.payout_maximum,
        "highest_ratio": limits.maximum_tension / load.static_tension,
        "tension_per_metre": load.stiffness / load.static_tension,
        "stretch_weight": dt / parameters.guard.window,
        "slow_mean": SLOW_MEAN_FACTOR,
        "tension_peak": TENSION_PEAK,
        "tension_left": TENSION_LEFT,
        "tension_hold": TENSION_HOLD,
        "inertia": cable.a,
        "settled_at_rest": SETTLED_AT_REST,
        "blind_limit": BLIND_LIMIT,
        "held_time": HELD_TIME,
        "reported_again": REPORTED_AGAIN,
        "link_wait": WAIT,
    }
