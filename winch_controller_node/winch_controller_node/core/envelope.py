"""The envelope in front of the winch: from raw readings and the controller's order to the order that leaves.

What bounds an order is in C++ (`heave_core`, envelope.cpp). This shell fills what it sees, from raw readings, the
operator's requests and nominal parameters, and makes alarms of what it has done.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, NamedTuple

from heave_core.envelope_table import Bit, Cause, DriveState, Duty, MoveKind, Phase
from heave_core.library import READING_NAMES, Envelope, EnvelopeOrder
from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import MruStatus, WinchFault

from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.core.supervision.proof_design import PLAUSIBLE_LOAD
from winch_controller_node.core.supervision.supervision_design import DUTIES
from winch_controller_node.core.supervision.watch.load_watch import Episode
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import Measurements, WinchOrder
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.motion.trajectory import MoveRequest
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.envelope import EnvelopeParameters
from winch_controller_node.parameters.model import WinchModelParameters

MOVES = {
    "go": MoveKind.GO,
    "stop": MoveKind.STOP_MOVE,
    "halt": MoveKind.HALT,
    "drive": MoveKind.DRIVE,
    "stand": MoveKind.STAND,
}
"""Kinds of a request for a move."""

BOUND = Bit.AT_RATE | Bit.AT_TRAVEL | Bit.AT_STOP
"""Bits of an order that was bounded."""

NOTHING_READ = (math.nan, math.nan, math.nan, math.nan, 0.0, math.nan, math.nan)
"""Readings of a tick in which nothing came."""

TAKEN_OVER = {
    Cause.DRUM: ("DRUM_OFF_ORDER: distance", "distance"),
    Cause.DRIFT: ("DRUM_OFF_ORDER: drift", "distance"),
    Cause.BRAKE_SLIPS: ("DRUM_NOT_HELD: count", "distance"),
    Cause.RATE: ("ORDER_REPLACED: too fast", "speed"),
    Cause.TRAVEL: ("ORDER_REPLACED: too far", "travel"),
    Cause.FADE_LONG: ("STOP_OVERDUE", "time"),
    Cause.UNSEEN: ("STOP_OVERDUE", "time"),
}
"""Alarms of what had a limit, and what it calls the value that was beyond, by cause."""

READ = len(NOTHING_READ)
LIFT_RATE, DUTY, HELD_TENSION, REQUEST, ACKNOWLEDGED = (
    READING_NAMES.index(name) for name in ("lift_rate", "duty", "held_tension", "request", "acknowledged")
)
BITS, CAUSE, PHASE = (EnvelopeOrder._fields.index(name) for name in ("bits", "cause", "phase"))
"""Places of what was read and of what leaves in the core's rows."""

LOAD_JUMPED = int(Bit.LOAD_JUMPED)
"""Bit of a step that no load makes."""

FREE, LIMITED, RESTS, FAILED = (float(state) for state in DriveState)
"""What the drive reports of itself, as the core has it."""


class Asked(NamedTuple):
    """What an operator has asked for at a tick, by a mode and its requests."""

    mode: Mode  # active
    move: MoveRequest  # last request for the mean payout
    tension: float = math.nan  # to hold [N]; NaN: none
    # at which the mean payout is carried along where the place moves about which the tip heaves [m/s]
    lift_rate: float = 0.0
    time: float = math.nan  # of the tick [s]; NaN: readings are taken to be as new


def nominal_design(parameters: WinchControllerParameters, cable: CableModel, tick_period: float) -> dict[str, Any]:
    """Return the values of the core's `Design`, with ticks of `tick_period` [s].

    `parameters` are as an operator states them; `cable` is the nominal two-state cable at payout 0.
    """
    tension = cable.static_tension if math.isfinite(cable.static_tension) else 0.0
    ratio = parameters.limits.maximum_tension_ratio
    others = {
        "stop_deceleration": parameters.modes.stop_deceleration,
        "tension_travel": parameters.tension.travel,
        "largest_load": PLAUSIBLE_LOAD * tension,
        "highest_tension": ratio * tension,
        "jerk_time": parameters.move.jerk_time,
    }
    return {
        "tick_period": tick_period,
        "winch": _nominal_winch(parameters.winch),
        "cable": {
            "inertia": cable.natural_a,
            "participation": cable.participation,
            "damping": cable.b,
            "drag": cable.drag,
            "stiffness": cable.stiffness,
            "length": parameters.length,
            "static_tension": tension,
        },
        "envelope": others | _margins(parameters.envelope),
    }


def _nominal_winch(winch: WinchModelParameters) -> Mapping[str, float]:
    is_first_order = winch.law == "first_order"
    return {
        "is_first_order": is_first_order,
        "lag": 1.0 / winch.position_rate if is_first_order else winch.time_constant,
        "delay": winch.command_delay,
        "position_gain": winch.position_gain,
        "gain": winch.speed_gain,
        "hauling_gain": winch.hauling_gain,
        "creep": winch.creep,
        "reach": winch.set_point_reach * winch.speed_limit,
        "speed": winch.speed_limit,
        "acceleration": winch.acceleration_limit,
        "power": winch.power_limit,
    }


def _margins(parameters: EnvelopeParameters) -> dict[str, float]:
    names = (field.name for field in fields(EnvelopeParameters) if field.name != "active")
    return {name: float(getattr(parameters, name)) for name in names}


class OrderEnvelope:
    """The envelope of a controller.

    Parameters
    ----------
    parameters : as an operator states them
    cable : nominal two-state cable at payout 0
    tick_period : [s]
    source : of the orders, as an alarm names it
    """

    def __init__(
        self,
        parameters: WinchControllerParameters,
        cable: CableModel,
        tick_period: float,
        source: str = "the controller",
    ) -> None:
        self._dt = tick_period
        self._cable, self._length = cable, parameters.length
        self._core = Envelope(nominal_design(parameters, cable, tick_period))
        self._is_active, self._source = parameters.envelope.active, source
        self._has_begun = False
        self._depth, self._cause = math.nan, 0.0
        self._jumps = Episode(tick_period)
        self._move: MoveRequest | None = None
        # of the core, by name
        self.records = self._core.records if self._is_active else {**self._core.records, "envelope": None}
        # why it has taken over, in numbers and in words, until an operator acknowledges; 0, None: it has not
        self.cause = 0.0
        self.reason: Alarm | None = None

    def take_nominal(self, parameters: WinchControllerParameters) -> None:
        """Go by other nominal `parameters` from now on, as an operator states them; of the cable, another length."""
        cable, longer = self._cable, parameters.length / self._length
        cable = replace(cable, a=longer * cable.a, stiffness=cable.stiffness / longer)
        self._core.take_design(nominal_design(parameters, cable, self._dt))

    @property
    def last(self) -> EnvelopeOrder:
        """What left in the last tick, and why."""
        return self._core.last

    def acknowledge(self) -> None:
        """Release what is latched, once drum and order are at rest; an operator has asked for a mode.

        A load cell that has jumped is one that he knows of.
        """
        self._core.readings[ACKNOWLEDGED] = 1.0
        if self._core.order.item(PHASE) >= Phase.HELD:
            self.cause, self.reason = 0.0, None

    def distance_to(self, depth: float) -> float:
        """Return how much deeper than the newest raw reading of the depth sensor a `depth` is [m]; NaN without one."""
        return depth - self._depth

    def leave_out(self) -> None:
        """Let a tick pass in which nothing is read and the winch keeps the last order."""
        if self._is_active and self._has_begun:
            readings = self._core.readings
            is_acknowledged = readings.item(ACKNOWLEDGED)
            readings[:READ], readings[ACKNOWLEDGED:] = NOTHING_READ, (0.0, *self._core.order[:3])
            self._core.go()
            readings[ACKNOWLEDGED] = is_acknowledged

    def see(self, raw: Measurements, move: MoveRequest) -> None:
        """Take in what comes at a tick beside what the core reads: a `raw` depth, the last request for a `move`."""
        self._has_begun = True
        if depths := raw.of("depth"):
            self._depth = depths[-1].value
        if move is not self._move:
            self._move = move
            to_go = move.distance, move.target, move.reference
            of_move = (move.number, MOVES[move.kind], *to_go, move.speed, move.acceleration)
            self._core.readings[REQUEST:ACKNOWLEDGED] = of_move

    def news(self) -> list[Alarm]:
        """Return what is new since the order of the last tick has left."""
        before, self._cause = self._cause, self._core.order.item(CAUSE)
        jumps = self._jumps.begins(int(self._core.order.item(BITS)) & LOAD_JUMPED != 0)
        found = [ALARMS.alarm("SENSOR_DOUBTFUL, LOAD_CELL: jump", step=1e-3 * self.last.load_step)] if jumps else []
        if not self._cause or self._cause == before:
            return found
        self.cause, self.reason = self._cause, _alarm(self.last, self._source)
        return [*found, self.reason]

    def step(self, raw: Measurements, asked: Asked, order: WinchOrder) -> tuple[WinchOrder, list[Alarm]]:
        """Return the order that leaves in place of the controller's, and what is new; within bounds it is that `order`.

        `raw` : readings of the tick; `asked` : by an operator
        """
        self.see(raw, asked.move)
        readings = self._core.readings
        readings[:READ] = _readings(raw, asked.time)
        readings[DUTY] = DUTIES.get(asked.mode, Duty.OPERATE)
        if not self._is_active:
            return order, []
        readings[LIFT_RATE], readings[HELD_TENSION] = asked.lift_rate, asked.tension
        readings[ACKNOWLEDGED + 1 :] = order.payout, order.payout_rate, order.brake
        sent = self._core.go()
        readings[ACKNOWLEDGED] = 0.0
        if sent.payout == order.payout and sent.rate == order.payout_rate and bool(sent.brake) == order.brake:
            return order, self.news()
        return order._replace(payout=sent.payout, payout_rate=sent.rate, brake=bool(sent.brake)), self.news()


def _readings(raw: Measurements, time: float) -> tuple[float, ...]:
    """Return what was read at a tick of a `time` [s], the first rows of READINGS."""
    heave = rate = count = age = load = depth = math.nan
    for reading in raw.mru:
        if reading.status == MruStatus.OK:
            heave, rate = reading.heave, reading.heave_rate
    winch, drive = raw.winch, FREE
    if winch is not None:
        count, age = winch.encoder_payout, round(time - winch.time, 6)  # times of ticks are rounded otherwise
        if winch.fault != WinchFault.NONE:
            drive = FAILED
        elif winch.brake:
            drive = RESTS
        elif winch.limits_hit != 0:
            drive = LIMITED
    for cell in raw.of("load_cell"):
        load = cell.value
    for sensor in raw.of("depth"):
        depth = sensor.value
    return heave, rate, count, age, drive, load, depth


def _alarm(sent: EnvelopeOrder, source: str) -> Alarm:
    """Return the alarm of what the envelope took over for, `sent` in place of an order of a `source`."""
    cause = Cause(int(sent.cause))
    if cause is Cause.NOT_FINITE:
        return ALARMS.alarm("ORDER_REPLACED: not finite", source=source)
    if cause is Cause.HARM:
        return ALARMS.alarm("LOAD_SWUNG_HIGHER", ratio=sent.value)
    name, what = TAKEN_OVER[cause]
    values: dict[str, float | str] = {what: sent.value, "limit": sent.limit}
    if cause is Cause.BRAKE_SLIPS:
        values["held"] = "The drive is ordered to hold the drum" if sent.phase == Phase.CAUGHT else "Brake stays on"
    return ALARMS.alarm(name, **values)
