"""What a tick is supervised by: parameters, load and constants, as the core has them (`heave_core`, supervise.cpp)."""

from __future__ import annotations

from typing import Any

from heave_core.envelope_table import Duty
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

LONGEST_AGE = 6.0
"""Age of a depth reading up to which the estimate of its time is kept [s]: the largest latency, 5 s, and a second."""

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

DUTIES = {
    Mode.COMPENSATING: Duty.FOLLOW,
    Mode.CONSTANT_TENSION: Duty.TENSION,
    Mode.FADE_OUT: Duty.FADE,
    Mode.STOPPING: Duty.STOP,
    Mode.EMERGENCY_STOP: Duty.STOP,
}
"""What a mode is there for; in all others the drum does what an operator asks for."""

CONSTANTS = {
    "cautious": CAUTIOUS,
    "quiet_time": QUIET_TIME,
    "least_rate": LEAST_RATE,
    "least_authority": LEAST_AUTHORITY,
    "tension_memory": TENSION_MEMORY,
    "least_averaged": 1e-3,
    "mean_error": MEAN_ERROR,
    "hangs_least": 0.7,  # and it has not landed
    "hangs_most": 1.3,
    "least_off": 3.0,  # of tide, draught and trim
    "peak": PEAK,
    "peak_ratio": PEAK_OVER_SIGNIFICANT,
    "slow_mean": SLOW_MEAN_FACTOR,
    "tension_peak": TENSION_PEAK,
    "tension_left": TENSION_LEFT,
    "tension_hold": 300.0,
    "settled_at_rest": 0.01,  # a sea adds its own, up to what a law can settle
    "blind_limit": BLIND_LIMIT,
    "held_time": 5.0,
    "reported_again": 60.0,
    "grown": 1.5,  # a sea that rises
    "link_wait": WAIT,
}
"""Constants of supervision: meanings and units are in the core's table, SUPERVISION_DESIGN."""


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
        "duties": tuple(float(DUTIES.get(mode, Duty.OPERATE)) for mode in MODES),
        "command_timeout": WinchFault.COMMAND_TIMEOUT,
        "restart": WinchFault.DRIVE,
        "emergency_stop": WinchFault.EMERGENCY_STOP,
        "automatic": sum(1 << fault for fault in WinchFault if is_automatic(fault)),
        **CONSTANTS,
        "cable_weight": load.cable_weight,
        "more": parameters.length - design.length,
        "hanging": parameters.tension.hanging,
        "length": parameters.length,
        "tip_height": parameters.boom_tip_height,
        "payout_tolerance": parameters.health.payout_tolerance,
        "stretch": pull / (cable.stiffness * design.length),
        "longest_wait": LONGEST_WAIT * parameters.modes.settling_time,
        "peak_use": parameters.entry.peak_use,
        "payout_minimum": limits.payout_minimum,
        "payout_maximum": limits.payout_maximum,
        "highest_ratio": limits.maximum_tension / load.static_tension,
        "tension_per_metre": load.stiffness / load.static_tension,
        "stretch_weight": dt / parameters.guard.window,
        "inertia": cable.a,
    }
