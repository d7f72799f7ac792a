"""What the core's proofs go by: nominal values and the constants of what is a proof."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from winch_controller_node.core.estimation.sense_design import SENSOR
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.simulated_unit import hanging_cable

WINDOW = 20.0
"""Record by which a proof is made [s]: two waves of a long sea."""

SHORTEST = 8.0
"""Least record of a proof [s]."""

CERTAIN = 5.0
"""Slope over its standard error that a proof needs: a sound MRU was called reversed in no window."""

FOLLOWED = 0.05
"""Change of the length from which on another cable is taken, relative."""

PLAUSIBLE_LOAD = 10.0
"""Largest reading of the load cell that is used, over the static tension."""

COUNT_TIME = 2.0
"""Memory of the comparison of count and stated speed [s]."""

FALL_TIME, FALL_WINDOW = 0.3, 60.0
"""Time within which the tension falls, and memory of how it falls without a cause [s]."""

BLEND, UNREAD = 1.0, 0.5
"""Time constant with which heave corrects the integral of its rate; age of an MRU reading that is too old [s]."""

PROOFS = {
    "shortest": SHORTEST,
    "looked_every": 0.5,
    "patience": 60.0,  # three windows
    "quiet": 0.03,  # in it nothing moves
    "at_rest": 2.0,
    "low_pass": 0.25,
    "certain": CERTAIN,
    "alike": 0.6,
    "least_scale": 0.6,  # neither reversed nor twice: a load cell on a short cable says no more than that
    "most_scale": 1.4,
    "softness": (0.5, 0.7, 1.0, 1.4, 2.0),  # a rope half or twice as stiff as its sheet says
    "refuted": 3.0,
    "blend": BLEND,
    "unread": UNREAD,
    "largest_heave": 15.0,
    "largest_rate": 6.0,
    "largest_load": PLAUSIBLE_LOAD,
    "followed": FOLLOWED,
    "off_course": 0.1,
    "share_off": 0.4,
    "count_time": COUNT_TIME,
    "standing_speed": 0.02,
    "felt": 0.05,
    "fall_window": FALL_WINDOW,
    "spreads": 8.0,
    "slack_share": 0.5,
    "slack_time": 10.0,
    "settled": 5.0,  # the stop itself has shaken the load
    "held_time": 1.0,
}
"""Constants of the proofs: meanings and units are in the core's table, PROOF_DESIGN."""


def cable_at(cable: CableModel, ratio: float) -> CableModel:
    """Return a `cable` at `ratio` times its length: its compliance goes with that."""
    return replace(
        cable, a=cable.a * ratio, b=cable.b * ratio, drag=cable.drag * ratio, stiffness=cable.stiffness / ratio
    )


def proof_design(cable: CableModel, length: float, cable_length: float, tick_period: float) -> dict[str, Any]:
    """Return the values of the core's ProofDesign.

    Parameters
    ----------
    cable : nominal, of the unit that hangs on `cable_length` of it [m]
    length : at a payout of 0 [m]
    cable_length : [m]
    tick_period : [s]
    """
    times = {"tick_period": tick_period, "blend": BLEND, "unread": UNREAD}
    return {
        **PROOFS,
        **{name: SENSOR[name] for name in ("mru", "load_cell", "depth")},
        "tick_period": tick_period,
        "length": length,
        "cable_length": cable_length,
        "stiffness": cable.stiffness,
        "static_tension": cable.static_tension,
        "frequency": 1.0 / cable.natural_a**0.5,
        "kept": round(WINDOW / tick_period),
        "fall_ticks": max(round(FALL_TIME / tick_period), 2),
        "load": {**times, "cable": hanging_cable(cable, tick_period)},
    }
