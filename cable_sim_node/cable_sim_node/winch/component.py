"""The virtual winch: what a real winch drive does with the commands it gets, and with those it does not get.

State: payout u [m] (positive lets out) and its rate v [m/s], both 0 at the start. `drive` chooses what moves the drum:

- `speed_servo` (default), with the set-points held from the moment a command takes effect, by one of two laws:
  - `speed_servo`: u' = v, v' = clip((v_set - v)/T, acceleration_limit),
    v_set = clip(payout_rate + k_p (payout - u), speed_limit) with the set-points payout_rate and payout of the command.
    With k_p = 0 and inside the limits V(s)/V_set(s) = exp(-s tau)/(1 + T s); the payout set-point then has no effect.
    With k_p > 0, U(s)/U_set(s) = k_p exp(-s tau)/(T s^2 + s + k_p) for a payout_rate of 0, and
    (s + k_p) exp(-s tau)/(T s^2 + s + k_p) when payout_rate is the derivative of payout; overdamped for
    k_p < 1/(4 T). A gain that would let the drum swing long within its acceleration limit is refused, see
    `WinchParameters`.
  - `first_order`: u' = K (u_0 - u), thesis Eq. 6.1, u_0 the payout set-point; payout_rate has no effect.
  A payout set-point is in the encoder's count: the u that it is held against has the error of a faulty encoder.
- `electric`, `pump_controlled`, `valve_controlled`: drives with inertia, torque or pressure, friction, power and a
  speed loop of their own, on which the cable's tension acts back (`heave_drives`, an extra).

The command of tick k takes effect exactly at t_k + tau, tau = command_delay, also where that falls inside a tick; with
command_jitter each has a tau of its own, uniform about it, but none takes effect before the one sent before it.

What a drive may do otherwise than its controller assumes: limits towards hauling in that are lower than those towards
paying out, a gain other than 1 from set-point to speed, a dead zone of the set-point, play in the encoder's gear, and
a cable that lies at another radius than the drive and its encoder count by (limits then hold at the nominal radius).

What no command can make the servo do: exceed speed_limit, acceleration_limit or the payout range. A power limit
bounds the speed to power_limit/tension; where tension rises in motion the winch slows down to that speed within its
acceleration limit. A drive with its physics keeps the payout range as well; a load that is too much for it may
accelerate it, until its brake catches it 10 % above speed_limit.

Brake and faults: the brake is engaged at the start; a fresh command without a brake request releases it. A brake
request makes the winch stop with stop_deceleration and then brake. So do faults, and they latch: no fresh command for
command_timeout (counted from the moment the last one took effect, while released), a set-point that is not a finite
number, a trip of the drive, the emergency stop. A latched fault is left only by an explicit release: a fresh command
with a brake request and, the drum at rest, a fresh one without. A command is fresh when its sequence number is above
the last one taken; while a fault is latched a brake request with any other number is fresh too, so that a restarted
controller can take over.

A brake that does not hold: once the supervision has seen the braked drum slip, the drive holds it where it is, with the
brake still ordered, until the fault is released, the drive fails or the emergency stop takes its power.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from heave_node.interface.codes import WinchFault, WinchLimit, WinchRelease
from heave_node.interface.faults import FaultSchedule, FaultyValues
from heave_node.parameters import ParameterError
from heave_node.sensing.view import quantised
from heave_node.winch.fault_latch import FaultLatch
from heave_node.winch.motion_supervision import DrumReading, MotionSupervision

from cable_sim_node.winch.command_line import CommandLine, WinchCommand, round_to_tick
from cable_sim_node.winch.drives.interface import Drive, DriveCommand, DriveState
from cable_sim_node.winch.drives.speed_servo import SpeedServo
from cable_sim_node.winch.faulty_drum import FaultyDrum
from cable_sim_node.winch.installed_drives import SERVO, installed_drives
from cable_sim_node.winch.parameters import EncoderParameters, WinchParameters


class _Mode(enum.Enum):
    """What the drum does."""

    FOLLOW = enum.auto()
    """The set-points of the newest command."""
    STOP = enum.auto()
    """Come to rest at a constant deceleration."""
    HOLD = enum.auto()
    """At rest, brake engaged."""
    CATCH = enum.auto()
    """At rest, held by the drive, as the brake that is ordered does not hold."""


_AT_REST = (_Mode.HOLD, _Mode.CATCH)

_SLOWER = WinchLimit.SPEED | WinchLimit.POWER | WinchLimit.TORQUE | WinchLimit.PRESSURE | WinchLimit.FLOW
"""Limits of a drive that make the drum slower than ordered."""


class WinchState(NamedTuple):
    """State of the winch at the end of a tick."""

    time: float  # simulated time [s]
    command_sequence: int  # number of the newest command taken; 0: none yet
    payout: float  # truth [m]
    payout_rate: float  # truth [m/s]
    payout_acceleration: float  # truth [m/s^2]
    encoder_payout: float  # the encoder's reading [m]
    encoder_payout_rate: float  # its difference over the tick by the tick [m/s]
    tension: float  # tension at the drum, as given [N]; NaN: unknown
    power: float  # -tension*payout_rate, positive when hauling in [W]; NaN: unknown
    limits_hit: WinchLimit  # limits that acted within the tick
    brake: bool  # the brake is engaged
    fault: WinchFault  # why the winch stopped by itself
    release: WinchRelease  # what a latched fault waits for


class Encoder:
    """The drum encoder: payout rounded to its resolution, with faults. The drive's position loop counts by it.

    Parameters
    ----------
    parameters : resolution [m] and scheduled faults

    Attributes
    ----------
    error : what its faults add to the payout, as it last read a number [m]
    """

    def __init__(self, parameters: EncoderParameters) -> None:
        self._resolution = parameters.resolution
        self._play = 0.5 * parameters.backlash
        self._position = 0.0
        self.faults = FaultSchedule(parameters.faults, name="encoder", device="encoder")
        self._faulty_values = FaultyValues(self.faults)
        self.error = 0.0

    def read(self, time: float, payout: float) -> float:
        """Return the reading [m] of the true `payout` [m] at `time` [s]; NaN under a nan fault."""
        self._position = min(max(self._position, payout - self._play), payout + self._play)
        value = self._faulty_values.apply(time, self._position)
        self.error = value - self._position if math.isfinite(value) else self.error
        return quantised(value, self._resolution)


class VirtualWinch:
    """The winch as a component: a command per tick in, the state at the end of the tick out.

    Parameters
    ----------
    parameters : the winch
    tick_period : [s]
    seed : of the jitter

    Attributes
    ----------
    faults, encoder.faults : fault schedules; faults may be injected during the run
    latch : of faults
    refused_commands : commands that were neither fresh nor the newest one again, so far
    """

    def __init__(self, parameters: WinchParameters, *, tick_period: float, seed: int = 0) -> None:
        self._parameters = parameters
        self._drive: Drive | None = make_drive(parameters, 0.0) if parameters.drive == SERVO else None
        self._tick_period = tick_period
        self.faults = FaultSchedule(parameters.faults, name="winch", device="winch", seed=seed)
        self._drum = FaultyDrum(parameters, self.faults)
        self._supervision = MotionSupervision(parameters.supervision_time)
        self._sound = SpeedServo(sound := replace(parameters, speed_gain=1.0))
        # it then moves as a sound drive does, from the same place and rate
        self._is_sound = parameters == sound and parameters.drive == SERVO and not parameters.drift.duration
        self.encoder = Encoder(parameters.encoder)
        self.refused_commands = 0
        self._now = 0.0  # [ticks]
        self._moved = DriveState(0.0, 0.0, 0.0, 0.0, 0.0, WinchLimit.NONE, True)
        self._tension = 0.0
        self._mode = _Mode.HOLD
        self.latch = FaultLatch()
        self._line = CommandLine(parameters, self.faults, tick_period=tick_period, seed=seed)
        self._command = WinchCommand(0)
        self._deadline = self._deadline_from(0.0)
        self._caught_at = 0.0
        reading = self.encoder.read(0.0, 0.0)
        self.state = self._make_state(WinchLimit.NONE, math.nan, (reading, reading))

    @property
    def _cable_per_drum(self) -> float:
        return 1.0 + self._parameters.drum_radius_error

    @property
    def tick(self) -> int:
        """Number of the next tick to be stepped; `state` is that at its start."""
        return round(self._now)

    def step(self, tick: int, command: WinchCommand | None, tension: float = math.nan) -> WinchState:
        """Take the command of `tick` and return the state at the end of the tick.

        Parameters
        ----------
        tick : k, the interval [t_k, t_{k+1}]; ticks left out (real time, late caller) are run without a command first
        command : what arrived for this tick; None: nothing
        tension : cable tension at the drum [N]; NaN: unknown, the last known one acts on

        Raises
        ------
        ValueError : `tick` lies before the state the winch is in; ParameterError, a ValueError too, where the drive
            cannot hold the first tension.
        """
        if tick < self.tick:
            raise ValueError(f"virtual winch: tick {tick} is over; the next one is {self.tick}")
        self._line.send(tick, command)
        ticks = tick + 1 - self.tick
        limits = self._advance_to(float(tick + 1), tension)
        reading = self.encoder.read(self._now * self._tick_period, self._moved.payout)
        rate = (reading - self.state.encoder_payout) / (ticks * self._tick_period)
        self._supervise(limits)
        self.state = self._make_state(limits, tension, (reading, rate))
        return self.state

    def _advance_to(self, end: float, tension: float) -> WinchLimit:
        """Move the drum to `end` [ticks], event by event; return the limits that acted."""
        limits = WinchLimit.NONE
        while self._now < end:
            self._handle_events()
            following = min(end, self._next_event())
            acted = self._move((following - self._now) * self._tick_period, tension)
            limits = acted if limits is WinchLimit.NONE else limits | acted
            self._now = following
        return limits

    @property
    def supervised(self) -> str:
        """What the drive's supervision tripped for last, in words; "": nothing yet."""
        return self._supervision.found + ("; the drive holds it" if self._mode is _Mode.CATCH else "")

    def _supervise(self, limits: WinchLimit) -> None:
        """Trip the drive where drum or brake do not do what they are ordered, and hold a drum that slips.

        It goes by the drive's own feedback: an encoder at the drum that fails is no fault of drum or brake. An order
        counts from when a sound drive follows it: with the lag and the limits of this winch, as far as it says. Where a
        drive with its physics is at a limit, a drum that goes slower than ordered follows.

        Parameters
        ----------
        limits : that acted in the last step
        """
        is_braked, brake = self._mode is not _Mode.FOLLOW, float(self._drum.is_brake_engaged)
        ordered = self._sound.state.payout_rate
        if limits is not WinchLimit.NONE and limits & _SLOWER:
            ordered = min(max(self._moved.payout_rate, min(ordered, 0.0)), max(ordered, 0.0))
            self._sound.state = self._sound.state._replace(payout_rate=ordered)
        drum = DrumReading(ordered, is_braked, self._moved.payout, self._moved.payout_rate, brake)
        found = self._supervision.look(self._now * self._tick_period, drum)
        if found and self._mode is not _Mode.CATCH:
            self._trip(WinchFault.DRIVE, found)
            if (
                self._mode is _Mode.HOLD
                and self._supervision.is_slipping
                and self.latch.fault is not WinchFault.EMERGENCY_STOP
            ):
                self._mode, self._caught_at = _Mode.CATCH, self._moved.payout

    def _handle_events(self) -> None:
        """Do what is due now: commands first, so that one at the very deadline is in time; then watchdog and faults."""
        time = self._now * self._tick_period
        while (command := self._line.take(self._now)) is not None:
            self._take(command)
        if self._mode is _Mode.FOLLOW and self._now >= self._deadline:
            self._trip(WinchFault.COMMAND_TIMEOUT)
        if self.faults.is_active("drive", time):
            self._trip(WinchFault.DRIVE)
        if self.faults.is_active("emergency_stop", time):
            self._trip(WinchFault.EMERGENCY_STOP)

    def _next_event(self) -> float:
        """Return the time of the next event after now [ticks]."""
        start = self.faults.next_start(("drive", "emergency_stop"), self._now * self._tick_period)
        fault = round_to_tick(start / self._tick_period) if math.isfinite(start) else math.inf
        deadline = self._deadline if self._mode is _Mode.FOLLOW else math.inf
        events = (fault, self._line.next_effect, deadline)
        return min([event for event in events if event > self._now], default=math.inf)

    def _deadline_from(self, now: float) -> float:
        """Return when the watchdog trips if no command comes after `now` [ticks]."""
        return round_to_tick(now + self._parameters.command_timeout / self._tick_period)

    def _take(self, command: WinchCommand) -> None:
        """Let a command take effect."""
        is_resync = bool(self.latch.fault) and command.brake and command.sequence != self._command.sequence
        if command.sequence <= self._command.sequence and not is_resync:
            self.refused_commands += 1
            return
        if not command.is_finite():
            self._command = self._command._replace(sequence=command.sequence)
            self._trip(WinchFault.INVALID_COMMAND)
            return
        self._command = command
        self._deadline = self._deadline_from(self._now)
        if command.brake:
            self.latch.acknowledge()
            self._stop(_Mode.FOLLOW)
            return
        self.latch.release(is_at_rest=self._mode in _AT_REST)
        if not self.latch.fault:
            self._mode = _Mode.FOLLOW

    def _trip(self, fault: WinchFault, words: str = "") -> None:
        """Latch a `fault`, found as `words` say, and stop."""
        self.latch.trip(fault, words)
        self._stop(_Mode.FOLLOW, _Mode.CATCH)

    def _stop(self, *moved_by_drive: _Mode) -> None:
        if self._mode in moved_by_drive:
            self._mode = _Mode.STOP

    def _move(self, duration: float, tension: float) -> WinchLimit:
        """Move the drum for `duration` [s] under the present command; return the limits that acted."""
        if math.isfinite(tension):
            # the drum feels the cable at the radius at which it lies, not at the nominal one
            self._tension = tension * self._cable_per_drum
        elif self._drive is None and self._mode is _Mode.HOLD:
            return WinchLimit.NONE  # before the cable is known the brake holds the drum
        if self._drive is None:
            self._drive = make_drive(self._parameters, self._tension)
        order, time, moved, before = self._order(), self._now * self._tick_period, self._moved, self._drive.state
        given = self._drum.ordered(order, time, moved.payout)
        sound = self._sound.state._replace(payout=moved.payout)
        if self._mode is not _Mode.FOLLOW:
            sound = sound._replace(payout_rate=moved.payout_rate)  # at rest: as the drum
        driven = self._drive.step(given, duration, self._tension)
        self._sound.state = sound
        if self._is_sound and given is order and before[:2] == sound[:2]:
            self._sound.state = driven
        else:
            self._sound.step(order, duration, self._tension)
        if self._mode is _Mode.STOP and driven.payout_rate == 0.0:
            self._mode = _Mode.HOLD
        is_at_rest, is_held = self._mode in _AT_REST, self._mode is _Mode.CATCH
        self._moved = self._drum.moved(
            driven, is_at_rest=is_at_rest, is_held=is_held, time=time, duration=duration, tension=self._tension
        )
        return self._moved.limits

    def _order(self) -> DriveCommand:
        if self._mode is _Mode.CATCH:
            return DriveCommand(0.0, self._caught_at)
        place = self._command.payout - self.encoder.error
        return DriveCommand(self._command.payout_rate, place, brake=self._mode is not _Mode.FOLLOW)

    def instruments(self) -> Mapping[str, float]:
        """Return what the drive's own instruments read, by name with unit; nothing for the ideal servo."""
        return self._drive.instruments() if self._drive is not None else {}

    def _make_state(self, limits: WinchLimit, tension: float, encoder: tuple[float, float]) -> WinchState:
        payout, rate, acceleration = (self._cable_per_drum * part for part in self._moved[:3])
        return WinchState(
            time=self._now * self._tick_period,
            command_sequence=self._command.sequence,
            payout=payout,
            payout_rate=rate,
            payout_acceleration=acceleration,
            encoder_payout=encoder[0],
            encoder_payout_rate=encoder[1],
            tension=tension,
            power=-tension * self._cable_per_drum * self._moved.payout_rate,
            limits_hit=limits,
            brake=self._drum.is_brake_engaged,
            fault=self.latch.fault,
            release=self.latch.waits_for(is_at_rest=self._mode in _AT_REST),
        )


def make_drive(parameters: WinchParameters, tension: float) -> Drive:
    """Return the drive of a winch, at rest under a tension.

    Parameters
    ----------
    parameters : the winch; its limits, payout range and position gain are the drive's
    tension : at the drum [N]

    Raises
    ------
    ParameterError : the drive is too weak for that tension.
    """
    name = parameters.drive
    if name == SERVO:
        return SpeedServo(parameters)
    try:
        driven: Drive = installed_drives()[name].make(parameters, getattr(parameters, name), tension)
    except ValueError as error:
        raise ParameterError(
            f"drive = {name} cannot hold the cable's {tension:.0f} N at the start: {error}; make it stronger"
        ) from error
    return driven
