"""The fixed controller: filter, law, governor and envelope of one design, with nothing that learns or changes mode.

It is the reference of the one in C, `controller.c`, and says which variables that has. Left out is all that a ship's
controller needs besides, see LEFT_OUT.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from cable_sim_node.conversions import WINCH_COMMAND
from heave_bringup.errors import CommandError
from heave_core.envelope_table import Duty
from heave_core.law import LoopNow, Place
from heave_core.law_table import COMMAND_STATE, Way
from heave_core.library import READING_NAMES, Envelope, new
from heave_node.interface import topics
from heave_node.interface.sensors import DEPTH, MRU, Water, WireReading
from winch_controller_node.core.envelope import nominal_design
from winch_controller_node.core.estimation.sense_design import tick_of
from winch_controller_node.core.loop_command import LEAK, REACH, commander
from winch_controller_node.design.design import ControllerDesign, design_controller
from winch_controller_node.interface.sensors import LEVER_ARM_X, LEVER_ARM_Y, MRU_SCALE
from winch_controller_node.laws.state_feedback import StateFeedback
from winch_controller_node.model.estimator import Measurement
from winch_controller_node.model.loop_rows import loop_rows
from winch_controller_node.model.simulated_unit import SimulatedUnit
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_fmu.messages import CONTROLLER_FIELDS, sensor_slots
from heave_fmu.part import STEPS, Part

SENSORS_TAKEN = {"mru", "depth", "encoder"}
"""Sensors that the fixed controller takes, and needs."""

LEFT_OUT = (
    "Fixed: its last step is the envelope, latched until it is reset, without load cell; otherwise no supervision, no "
    "sensor health, no modes, no moves, no adviser; "
    "near the limits of the winch law lqg stays linear"
)
"""What the fixed controller has not, in a line."""


class Seen(NamedTuple):
    """What the envelope reads in a tick; NaN: none came."""

    heave: float = math.nan  # raw, of the boom tip [m]
    heave_rate: float = math.nan  # raw, of the boom tip [m/s]
    payout: float = math.nan  # raw count of the drum [m]


NOTHING_SEEN = Seen()
"""A tick without a reading."""


def last_step_readings(seen: Seen, payout: float, rate: float, *, is_braked: bool) -> tuple[float, ...]:
    """Return the readings of the core's envelope.

    Parameters
    ----------
    seen : in the tick
    payout, rate : set-points that are ordered [m], [m/s]
    is_braked : the brake is ordered
    """
    unknown = dict.fromkeys(("load", "held_tension", "target", "reference"), math.nan)
    order = {"payout": payout, "rate": rate, "brake": float(is_braked)}
    given = {"mru_heave": seen.heave, "mru_rate": seen.heave_rate, "count": seen.payout, "request": -1.0}
    given |= unknown | order | {"duty": float(Duty.OPERATE if is_braked else Duty.FOLLOW)}
    return tuple(given.get(name, 0.0) for name in READING_NAMES)


class FixedControllerPart(Part):
    """Filter, law, governor and envelope of the design that the parameters of the loop give; see Part.

    The brake stays on for `modes.settling_time`; then authority goes to `factor` over `modes.fade_in_time`. The drum is
    at a payout of 0 at first, and that is the mean payout.

    Raises CommandError, in one line, for a loop that it is not for.

    Attributes
    ----------
    design : the active one; law : of it
    taut_cable : of the unit as it moves with the winch locked: it is never slack
    water : assumed
    """

    instant = 0.5 / STEPS

    def declare(self) -> None:
        """See Part."""
        self.design, self.law = _fixed(self.parameters.controller, self.tick_period)
        if sensor_slots(DEPTH, self.parameters.plant.sensors) > 1:
            raise CommandError("the fixed controller takes one reading of a sensor a tick: no fault `delay` of depth")
        self.add_input(MRU.topic, ("heave", "heave_rate", "status"))
        self.add_input(DEPTH.topic, DEPTH.values)
        self.add_input(topics.WINCH_STATE, ("encoder_payout",))
        self.add_output(topics.WINCH_COMMAND, WINCH_COMMAND)
        self.add_output(topics.CONTROLLER_STATE, CONTROLLER_FIELDS)
        controller = self.design.parameters
        self.water = Water(controller.water_density, controller.gravity)
        self.taut_cable = replace(self.design.cable, unit_weight=math.inf)
        self.nominal = nominal_design(controller, self.design.cable, self.tick_period)

    def start(self) -> None:
        """See Part."""
        design, dt = self.design, self.tick_period
        self._rows, self._estimator = loop_rows(design.model), design.make_estimator()
        self._commander = commander(design, self.law.winch, self.law, new(COMMAND_STATE))
        self._free_unit = SimulatedUnit(self.taut_cable, dt)
        self._command, self._authority, self._depth_zero = 0.0, 0.0, math.nan
        self.envelope, self._seen = Envelope(self.nominal), NOTHING_SEEN
        self._place = Place(LEAK, REACH)

    def step(self, tick: int) -> list[str]:
        """See Part."""
        controller, dt = self.design.parameters, self.tick_period
        self._seen = NOTHING_SEEN
        estimate = self._estimator.step(tick, self._command, self._readings(self.stamp(tick)))
        free = self._free_unit.step(self._rows.tip @ estimate)
        gain = controller.winch.position_gain
        brake = tick * dt < controller.modes.settling_time
        if not brake:
            step = dt / controller.modes.fade_in_time
            self._authority += min(max(controller.factor - self._authority, -step), step)
        self._commander.estimate[:] = estimate
        way = Way.BY_BRAKE if brake else Way.BY_LAW
        self._commander.act(LoopNow(way, self._authority, *free.tolist()))
        made = self._commander.made
        self._command, sent = made.value, 0.0 if brake else made.sent
        place = made.payout if brake and gain > 0.0 else 0.0
        order = self.envelope.step(last_step_readings(self._seen, place, sent, is_braked=brake))
        if order.brake and not brake:
            self._command = made.standing
        elif order.rate != sent:
            self._command += (order.rate - sent) * controller.winch.gain_at(order.rate - sent)
        is_braked = bool(order.brake)
        speed = order.rate + (0.0 if is_braked else gain * (order.payout - made.payout))
        at_end = self._place.at_end(dt, speed, float(self._rows.payout @ estimate), is_braked=is_braked)
        held = 0.0 if is_braked else gain * (order.payout - at_end)
        # the mean payout is that of the start, 0
        self.send(topics.WINCH_COMMAND, tick, (tick, at_end, order.rate + held, is_braked, 0.0))
        self.send(topics.CONTROLLER_STATE, tick, ("standby" if brake else "compensating", self._authority, 0.0))
        return []

    def _readings(self, now: int) -> list[Measurement]:
        """Return the readings that came since the last tick, in the terms of the filter; `now` is in [ns]."""
        taken = []
        mru = self.inputs[MRU.topic.name].newest(now)
        if mru is not None:
            heave, rate, status = mru.numbers
            if status == 0:
                taken = [("mru_heave", heave, mru), ("mru_heave_rate", rate, mru)]
                self._seen = self._seen._replace(heave=heave, heave_rate=rate)
        winch = self.inputs[topics.WINCH_STATE.name].newest(now)
        if winch is not None:
            taken.append(("payout", winch.numbers[0], winch))
            self._seen = self._seen._replace(payout=winch.numbers[0])
        pressure = self.inputs[DEPTH.topic.name].newest(now)
        if pressure is not None:
            (depth,) = DEPTH.from_wire(pressure, self.water)
            if math.isnan(self._depth_zero):
                self._depth_zero = depth
            taken.append(("unit_heave", self._depth_zero - depth, pressure))
        return [self._measurement(*one) for one in taken if math.isfinite(one[1])]

    def _measurement(self, name: str, value: float, reading: WireReading) -> Measurement:
        tick, offset = tick_of(reading.time, self.tick_period)
        return Measurement(name, value, tick, offset=offset)


def _fixed(parameters: WinchControllerParameters, tick_period: float) -> tuple[ControllerDesign, StateFeedback]:
    """Return design and law of a fixed controller by its `parameters`, in ticks of `tick_period` [s].

    Raises CommandError where that would not be the controller that they ask for.
    """
    design = design_controller(parameters, tick_period=tick_period)
    law, winch, sensors = design.make_law(), parameters.winch, set(parameters.sensors.use)
    if not isinstance(law, StateFeedback):
        raise CommandError(
            f"the fixed controller is a linear law, and law {parameters.law} is none: --set winch_controller.law=lqg"
        )
    if winch.law != "speed_servo" or np.isfinite(design.limits.power):
        raise CommandError("the fixed controller is for a speed servo without a limit of power")
    if sensors != SENSORS_TAKEN or {MRU_SCALE, LEVER_ARM_X, LEVER_ARM_Y} & set(design.model.state_names):
        raise CommandError(
            "the fixed controller takes mru, depth, encoder, and estimates no scale and no lever arm of the MRU"
        )
    law.stay_linear()
    return design, law
