"""What lies between the components of a loop and can fail: links, clocks, nodes that end, an adviser that lies."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from cable_sim_node.winch.command_line import WinchCommand
from heave_bringup.closed_loop import ClosedLoop
from heave_node.interface.faults import FaultSchedule
from winch_controller_node.beliefs.beliefs import Belief, Beliefs, EncoderScale, parameters_under
from winch_controller_node.beliefs.quantities import ENCODER_SCALE, MRU_SCALE
from winch_controller_node.design.design import design_controller
from winch_controller_node.interface.readings import Measurements, Outputs
from winch_controller_node.model.lqr import DesignError

from tests.campaigns.fault_matrix.faults import Fault

LIES = {
    "encoder_scale": ENCODER_SCALE,
    "speed_gain": "winch.speed_gain",
    "command_delay": "winch.command_delay",
    "inertia": "cable.inertia_factor",
    "mru_scale": MRU_SCALE,
    "nan": "winch.speed_gain",
}
"""Quantity that an adviser lies about, by kind of fault."""

LIAR = 1_000_000
"""Number of answers that are lies: another than any before."""

Waiting = tuple[int, Measurements]


class Wires:
    """Wiring of a `loop`: hands everything on as it is until a fault is `begin`.

    Attributes
    ----------
    ordered : rate that the drive was last sent [m/s]; NaN: to brake
    """

    def __init__(self, loop: ClosedLoop, tick_period: float) -> None:
        self._loop, self._dt = loop, tick_period
        self._fault, self._start, self._end = Fault(""), math.inf, math.inf
        self._waiting: list[Waiting] = []
        self._last: Outputs | None = None
        self._stuck: float | None = None
        self._lie: Beliefs | None = None
        self.ordered = math.nan
        self._control: Callable[[int, Measurements], Outputs] = loop.controller.step
        self._drive = loop.winch.step
        setattr(loop.controller, "step", self._controlled)  # noqa: B010 - a method of a component, for this loop alone
        setattr(loop.winch, "step", self._driven)  # noqa: B010
        if loop.adviser is not None:
            self._advise = loop.adviser.advise
            setattr(loop.adviser, "advise", self._advised)  # noqa: B010

    def begin(self, fault: Fault) -> None:
        """Let a `fault` begin with the next tick."""
        now = self._loop.tick * self._dt
        device, kind = fault.kind.device, fault.kind.kind
        self._start, self._end = now, now + (fault.duration or math.inf)
        schedule = self._schedule(device)
        if schedule is not None:
            schedule.inject(kind, start=now, duration=fault.duration, magnitude=fault.magnitude)
        elif device == "node" and kind in ("wave_vessel", "cable_sim"):
            groups = ("mru",) if kind == "wave_vessel" else ("depth", "load_cell")
            for group in groups:
                self._sensor(group).inject("gap", start=now, duration=fault.duration)
        elif (device, kind) == ("adviser", "ends"):
            self._loop.adviser = None
        else:
            self._fault = fault
        if (device, kind) == ("node", "virtual_winch"):
            self._loop.winch.faults.inject("gap", start=now, duration=fault.duration)

    def _schedule(self, device: str) -> FaultSchedule | None:
        if device == "winch":
            return self._loop.winch.faults
        return self._sensor(device) if device in ("mru", "encoder", "depth", "load_cell") else None

    def _sensor(self, name: str) -> FaultSchedule:
        if name == "mru":
            return self._loop.sea.mru.faults
        return self._loop.winch.encoder.faults if name == "encoder" else self._loop.plant.sensors[name].faults

    def _is(self, device: str, *kinds: str) -> bool:
        """Tell whether such a fault is active in this tick."""
        now = self._loop.tick * self._dt
        kind = self._fault.kind if self._fault.name else None
        active = kind is not None and kind.device == device and kind.kind in kinds
        return active and self._start <= now < self._end

    # measurements

    def _controlled(self, tick: int, measurements: Measurements) -> Outputs:
        if self._is("node", "winch_controller", "stalled") and self._last is not None:
            self._waiting.append((tick, measurements))
            return self._last._replace(alarms=(), make_kpi=None, make_observations=None, requests=())
        if self._waiting:
            measurements = self._caught_up(measurements)
        if self._is("clock", "mru", "depth", "winch"):
            measurements = _shifted(measurements, self._fault.kind.kind, self._fault.magnitude)
        if self._is("node", "virtual_winch"):
            measurements = replace(measurements, winch=None)
        self._last = self._control(tick, measurements)
        return self._last

    def _caught_up(self, measurements: Measurements) -> Measurements:
        """Let the controller predict the ticks that it slept through; return all that was measured meanwhile."""
        for tick, _ in self._waiting:
            self._loop.controller.leave_out(tick)
        heard = [one for _, one in self._waiting] + [measurements]
        self._waiting = []
        names = {name for one in heard for name in one.scalar}
        return replace(
            measurements,
            mru=tuple(reading for one in heard for reading in one.mru),
            scalar={name: tuple(reading for one in heard for reading in one.of(name)) for name in names},
        )

    # orders

    def _driven(self, tick: int, command: WinchCommand, tension: float) -> Any:
        if self._is("node", "winch_controller", "stalled"):
            return self._drive(tick, None, tension)
        if self._is("orders", "nan"):
            command = command._replace(payout_rate=math.nan)
        elif self._is("orders", "reversed", "factor"):
            times = -1.0 if self._fault.kind.kind == "reversed" else self._fault.magnitude
            command = command._replace(payout_rate=times * command.payout_rate)
        elif self._is("orders", "stuck"):
            self._stuck = command.payout_rate if self._stuck is None else self._stuck
            command = command._replace(payout_rate=self._stuck)
        self.ordered = math.nan if command.brake else command.payout_rate
        return self._drive(tick, command, tension)

    # the adviser

    def _advised(self, observations: Any) -> Beliefs:
        if self._is("adviser", "late"):
            return replace(self._advise(observations), asked=observations.last - round(10.0 / self._dt))
        answer = self._advise(observations)
        if not self._is("adviser", *LIES, "excluded"):
            return answer
        if self._lie is None:
            self._lie = self._made_up(answer)
        return replace(self._lie, asked=answer.asked)

    def _made_up(self, answer: Beliefs) -> Beliefs:
        """Return a lie, with the design that goes with it."""
        kind, value = self._fault.kind.kind, self._fault.magnitude
        answer = replace(answer, number=LIAR, findings=(), adopted=None)
        if kind == "excluded":
            return replace(answer, excluded="mru")
        quantity = LIES[kind]
        value = math.nan if kind == "nan" else value
        lie = replace(answer, values=MappingProxyType({**answer.values, quantity: Belief(quantity, value, nats=1e3)}))
        if kind == "encoder_scale":
            reading = self._loop.winch.state.encoder_payout
            return replace(lie, encoder=EncoderScale(answer.asked, value, reading, reading))
        if kind in ("command_delay", "inertia"):
            parameters = parameters_under(lie, self._loop.controller.nominal)
            try:
                return replace(lie, design=design_controller(parameters, tick_period=self._dt).with_own_gains())
            except DesignError:
                return lie
        return lie


def _shifted(measurements: Measurements, sensor: str, offset: float) -> Measurements:
    """Return `measurements` in which the stamps of a `sensor` are off by an `offset` [s]."""
    if sensor == "mru":
        return replace(measurements, mru=tuple(one._replace(time=one.time + offset) for one in measurements.mru))
    if sensor == "winch":
        winch = measurements.winch
        return replace(measurements, winch=None if winch is None else winch._replace(time=winch.time + offset))
    moved = tuple(one._replace(time=one.time + offset) for one in measurements.of(sensor))
    return replace(measurements, scalar={**measurements.scalar, sensor: moved})
