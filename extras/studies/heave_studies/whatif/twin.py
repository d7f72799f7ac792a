"""The twin of a record: cable and unit, winch, and the loop closed over what was read.

reading now = reading of the record + twin(boom tip, payout asked now) - twin(boom tip, recorded payout)

Errors of boom tip, disturbance and noise are in both twins and cancel to first order; the same orders as in the record
give its readings back to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from cable_sim_node.vertical.axial_line import AxialLine
from cable_sim_node.vertical.axial_stepper import AxialInput, AxialStepper
from cable_sim_node.winch.command_line import WinchCommand
from cable_sim_node.winch.component import VirtualWinch, WinchState
from cable_sim_node.winch.parameters import EncoderParameters, WinchParameters
from heave_core.watch import NO_POWER_LIMIT
from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import WinchLimit
from heave_node.numerics.arrays import Array
from winch_controller_node.adviser.component import Adviser
from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.beliefs.drum import drum_of
from winch_controller_node.core.component import WinchController
from winch_controller_node.design.design import assumed_cable, assumed_plant
from winch_controller_node.interface.readings import Measurements, Outputs, ScalarReading, WinchReading
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.whatif.record import Flags, SensorRecord
from heave_studies.whatif.spectra import SLOWEST, Tip, smoothed

SEGMENTS, SUBSTEPS = 12, 4
"""Elements along the cable, and steps in a tick: 0.4 mm of a motion of 0.6 m (sigma) from a mesh refined threefold."""


@dataclass(frozen=True)
class PlantFactors:
    """What cable and unit are, over what the parameters say."""

    inertia: float = 1.0  # on a, the unit's inertia over the cable's stiffness [-]
    damping: float = 1.0  # on the drag of the unit [-]
    cable_drag: float = 1.0  # on the drag of the cable [-]
    stiffness: float = 1.0  # on EA [-]; masses and drag go with it, so that the motion stays and the tension grows


def nominal_line(parameters: WinchControllerParameters) -> AxialLine:
    """Return cable and unit as the `parameters` of a controller state them, its own a and factors with them."""
    assumed = parameters.cable_model
    derived = replace(parameters, cable_model=replace(assumed, inertia=0.0, inertia_factor=1.0))
    a, length = assumed_cable(parameters, parameters.length).a, parameters.length
    drag = assumed.damping_factor
    factors = PlantFactors(a / assumed_cable(derived, length).a, drag, drag)
    return scaled_line(assumed_plant(parameters).line(length), factors)


def scaled_line(line: AxialLine, factors: PlantFactors) -> AxialLine:
    """Return a `line` with `factors` on it."""
    # all forces grow with the stiffness, so that the motion stays
    mass, unit_drag, cable_drag = (
        one * factors.stiffness for one in (factors.inertia, factors.damping, factors.cable_drag)
    )
    sections = tuple(
        replace(
            one,
            axial_stiffness=one.axial_stiffness * factors.stiffness,
            mass=one.mass * mass,
            drag=one.drag * cable_drag,
        )
        for one in line.sections
    )
    unit = replace(line.unit, inertia=line.unit.inertia * mass, drag=line.unit.drag * unit_drag)
    return replace(line, sections=sections, unit=unit)


@dataclass(frozen=True)
class PlantMotion:
    """Motion of the plant at each tick."""

    unit: Array  # heave of the unit about its rest at payout 0, positive up (n,) [m]
    velocity: Array  # its rate (n,) [m/s]
    tension: Array  # at the top (n,) [N]
    least_tension: Array  # the smallest along the cable (n,) [N]


class Drive(NamedTuple):
    """What moves a plant."""

    line: AxialLine  # cable and unit
    length: float  # unstretched, of the cable at payout 0 [m]
    tip: Tip  # of the record
    payout: Array  # of the cable at each tick (n,) [m]
    rate: Array  # of the cable at each tick (n,) [m/s]
    tick_period: float  # [s]

    @property
    def stepper(self) -> AxialStepper:
        """Twin of cable and unit at the first tick."""
        start = AxialInput(*(float(one[0]) for one in (self.tip.heave, self.tip.rate, self.payout, self.rate)))
        return AxialStepper(
            self.line, self.length, start, segments=SEGMENTS, duration=self.tick_period, substeps=SUBSTEPS
        )


def driven(drive: Drive) -> PlantMotion:
    """Return the motion of a plant under its `drive`."""
    stepper, rows = drive.stepper, np.column_stack((drive.tip.heave, drive.tip.rate, drive.payout, drive.rate))
    table = np.vstack((stepper.state, stepper.follow(rows[1:])))
    return PlantMotion(*table.T.copy())


AT_LIMIT = 10
"""Ticks at its speed limit from which on a drum has shown how fast it can be, in each direction."""


def speeds_shown(record: SensorRecord, encoder_scale: float) -> dict[float, float]:
    """Return the speed limits [m/s] that the drum of a `record` has shown, by direction: 1 pays out, -1 hauls in.

    They are the medians of its rate where the winch reports to be at its limit: one that an adviser has identified may
    be on trial. `encoder_scale` is reading over payout [-].
    """
    rate = np.array([math.nan if one.winch is None else one.winch.encoder_payout_rate for one in record.measurements])
    at_limit = rate[(record.limits_hit & WinchLimit.SPEED) != 0] / encoder_scale
    found = {way: way * at_limit[way * at_limit > 0.0] for way in (1.0, -1.0)}
    return {way: float(np.median(speeds)) for way, speeds in found.items() if speeds.size >= AT_LIMIT}


def winch_under(
    beliefs: Beliefs, nominal: WinchControllerParameters, shown: Mapping[float, float] = MappingProxyType({})
) -> WinchParameters:
    """Return the winch of a record.

    Parameters
    ----------
    beliefs : of the adviser, about the nominal winch
    nominal : parameters of the controller, which name that
    shown : speed limits that the drum has shown, as `speeds_shown` gives them; they come before those identified
    """
    assumed = {name: belief.value for name, belief in beliefs.values.items()}
    drum, winch = drum_of(nominal.winch, assumed), nominal.winch
    speed_out, speed_in = shown.get(1.0, drum.speed_out), shown.get(-1.0, drum.speed_in)
    speed, acceleration = max(speed_out, speed_in), max(drum.acceleration_out, drum.acceleration_in)
    return WinchParameters(
        law=winch.law,
        time_constant=drum.lag,
        position_gain=winch.position_gain,
        position_rate=winch.position_rate,
        command_delay=max(drum.delay, 0.0),
        speed_limit=speed,
        acceleration_limit=acceleration,
        stop_deceleration=min(acceleration, WinchParameters().stop_deceleration),
        hauling_speed_share=max(min(speed_in / speed, 1.0), 0.05),
        hauling_acceleration_share=max(min(drum.acceleration_in / acceleration, 1.0), 0.05),
        speed_gain=drum.gain,
        speed_deadband=drum.deadband,
        creep=drum.creep,
        payout_minimum=winch.payout_minimum,
        payout_maximum=winch.payout_maximum,
        power_limit=drum.power if drum.power < NO_POWER_LIMIT else 0.0,
        encoder=EncoderParameters(resolution=0.0, backlash=max(drum.backlash, 0.0)),
    )


@dataclass(frozen=True)
class PastWinch:
    """What the drum did in a record."""

    parameters: WinchParameters  # of its model
    payout: Array  # of the cable at each tick (n,) [m]
    rate: Array  # of the cable at each tick (n,) [m/s]
    modelled: Array  # payout of the model of the winch under the orders of the record, (n,) [m]
    modelled_rate: Array  # and its rate (n,) [m/s]
    error: float  # standard deviation of payout about the model's where waves are and above [m]


def past_winch(record: SensorRecord, parameters: WinchParameters, encoder_scale: float = 1.0) -> PastWinch:
    """Return what the drum did in a `record`: the model of the winch, and what the encoder shows beside it.

    Parameters
    ----------
    record : with an encoder, and the orders to the winch
    parameters : of the winch
    encoder_scale : reading over payout [-]
    """
    dt = record.tick_period
    twin = VirtualWinch(parameters, tick_period=dt)
    states = np.zeros((record.ticks, 3))
    for index in range(record.ticks - 1):
        order = record.orders[index]
        state = twin.step(record.first + index, order and WinchCommand(*order), record.tension[index])
        states[index + 1] = state.payout, state.payout_rate, state.encoder_payout
    modelled, rate, as_read = states.T.copy()
    # what stands above the encoder's noise is what the model of the winch misses
    found = smoothed(record.encoder / encoder_scale - as_read, dt)
    missed, waves = found.values, found.omega > SLOWEST
    error = math.sqrt(float(np.sum((found.kept**2 * found.power)[waves])) / record.ticks)
    return PastWinch(parameters, modelled + missed, rate + np.gradient(missed, dt), modelled, rate, error)


@dataclass(frozen=True)
class Past:
    """What a record has become: everything that another loop is closed over."""

    record: SensorRecord  # of the sensors
    drive: Drive  # cable and unit as identified, and what moved them
    winch: PastWinch  # what the drum did
    winch_parameters: WinchParameters  # what it is
    plant: PlantMotion  # motion of the twin under that
    encoder_scale: float = 1.0  # reading over truth [-]
    depth_scale: float = 1.0  # reading over truth [-]


@dataclass(frozen=True)
class Replayed:
    """What a loop has done over a record."""

    time: Array  # of each tick (n,) [s]
    payout: Array  # of the cable at each tick (n,) [m]
    rate: Array  # of the cable at each tick (n,) [m/s]
    set_point: Array  # mean payout that the controller worked about (n,) [m]
    unit: Array  # of the twin at each tick (n,) [m]
    tension: Array  # of the twin at each tick (n,) [N]
    modes: tuple[str, ...]  # of the controller in each tick
    alarms: tuple[tuple[float, Alarm], ...]  # time [s] and alarm
    limits_hit: Flags  # of the winch in each tick, sums of WinchLimit (n,)


@dataclass(frozen=True)
class Asked:
    """What is to be tried in a record."""

    controller: WinchControllerParameters  # parameters of the controller
    winch: WinchParameters | None = None  # parameters of the winch; None: as it is
    has_adviser: bool = True  # the loop identifies what is other than nominal, as on a ship

    @property
    def law(self) -> str:
        """Name of the law."""
        return self.controller.law


class Replay:
    """A loop over a record.

    Parameters
    ----------
    past : the record and its twins; None of the twins is asked while the orders are those of the record
    asked : what is tried in it

    Attributes
    ----------
    is_other : its orders, or its winch, were other than those of the record
    """

    def __init__(self, past: Past, asked: Asked) -> None:
        record = past.record
        dt, self._past = record.tick_period, past
        self._controller = WinchController(asked.controller, tick_period=dt)
        self._controller.skip_programme((record.first - 1) * dt)
        self._adviser = Adviser(asked.controller, tick_period=dt) if asked.has_adviser else None
        self._winch = VirtualWinch(asked.winch or past.winch_parameters, tick_period=dt)
        self.is_other = asked.winch is not None and asked.winch != past.winch_parameters
        self._payout, self._rate = float(past.winch.payout[0]), float(past.winch.rate[0])
        self._plant = past.drive.stepper
        # differences of the twins at each tick: heave, velocity and acceleration of the unit, tension, payout, its rate
        self._differences = np.zeros((record.ticks, 6))

    def run(self) -> Replayed:
        """Run to the end of the record."""
        record, rows, modes = self._past.record, [], []
        alarms: list[tuple[float, Alarm]] = []
        for index in range(record.ticks):
            outputs = self._step(index)
            modes.append(outputs.mode)
            alarms += [(float(record.time[index]), alarm) for alarm in outputs.alarms]
            unit, _, tension, _ = self._plant.state
            limits = self._winch.state.limits_hit if self.is_other else record.limits_hit[index]
            rows.append((self._payout, self._rate, outputs.depth_set_point, unit, tension, int(limits)))
            if index + 1 < record.ticks:
                order = WinchCommand(*outputs.order)
                self._advance(self._winch.step(record.first + index, order, tension), index + 1)
        payout, rate, point, unit, tension, limits = np.array(rows).T.copy()
        return Replayed(
            record.time, payout, rate, point, unit, tension, tuple(modes), tuple(alarms), limits.astype(int)
        )

    def _step(self, index: int) -> Outputs:
        """Let the controller do the tick of an `index`, and its adviser answer."""
        record = self._past.record
        given, was = record.measurements[index], record.orders[index]
        outputs = self._controller.step(record.first + index, self._as_read(given, index) if self.is_other else given)
        if self._adviser is not None and (observed := outputs.observations) is not None:
            self._controller.take(self._adviser.advise(observed))
        self.is_other |= was is not None and outputs.order != was
        return outputs

    def _advance(self, winch: WinchState, index: int) -> None:
        """Take the plant to the next tick, of an `index`, under what the winch has become, and note the differences."""
        past = self._past
        extra = winch.payout - past.winch.modelled[index] if self.is_other else 0.0
        extra_rate = winch.payout_rate - past.winch.modelled_rate[index] if self.is_other else 0.0
        self._payout, self._rate = past.winch.payout[index] + extra, past.winch.rate[index] + extra_rate
        heave, heave_rate = float(past.drive.tip.heave[index]), float(past.drive.tip.rate[index])
        self._plant.advance(AxialInput(heave, heave_rate, float(self._payout), float(self._rate)))
        unit, velocity, tension, _ = self._plant.state
        row, dt = self._differences[index], past.record.tick_period
        row[0], row[1] = unit - past.plant.unit[index], velocity - past.plant.velocity[index]
        row[2] = (row[1] - self._differences[index - 1, 1]) / dt
        row[3] = tension - past.plant.tension[index]
        row[4], row[5] = extra, extra_rate

    def _as_read(self, given: Measurements, index: int) -> Measurements:
        """Return what would have been read in place of what was `given`."""
        past = self._past
        scalar = {
            sensor: tuple(self._moved(sensor, one, index) for one in readings)
            for sensor, readings in given.scalar.items()
        }
        winch, state = given.winch, self._winch.state
        if winch is not None:
            extra, extra_rate = self._differences[index, 4:] * past.encoder_scale
            winch = WinchReading(
                winch.time,
                winch.encoder_payout + extra,
                winch.encoder_payout_rate + extra_rate,
                state.brake,
                int(state.fault),
                state.command_sequence,
                int(state.limits_hit),
            )
        return replace(given, scalar=scalar, winch=winch)

    def _moved(self, sensor: str, reading: ScalarReading, index: int) -> ScalarReading:
        """Return a `reading` moved by the difference of the twins at its time."""
        column, factor = MOVED[sensor]
        factor = -self._past.depth_scale if sensor == "depth" else factor
        place = reading.time / self._past.record.tick_period - self._past.record.first
        low = min(max(int(place), 0), index)
        high = min(low + 1, index)
        share = min(max(place - low, 0.0), 1.0)
        difference = (1.0 - share) * self._differences[low, column] + share * self._differences[high, column]
        return ScalarReading(reading.time, reading.value + factor * difference)


MOVED = {"depth": (0, -1.0), "velocity": (1, 1.0), "imu": (2, 1.0), "load_cell": (3, 1.0)}
"""Column of the differences by which each sensor reads otherwise, and its sign: depth is positive down."""


def replay(past: Past, asked: Asked) -> Replayed:
    """Return what the loop that is `asked` for would have done over the whole of `past`."""
    return Replay(past, asked).run()


def locked(record: SensorRecord, drive: Drive) -> Replayed:
    """Return what the winch at its mean payout would have been in a `record`, under that `drive`."""
    motion, never = driven(drive), np.zeros(record.ticks, dtype=int)
    rows = (drive.payout, drive.rate, drive.payout, motion.unit, motion.tension)
    return Replayed(record.time, *rows, ("off",) * record.ticks, (), never)
