"""The twin of a record: cable and unit, winch, and the loop closed over what was read.

reading now = reading of the record + twin(boom tip, payout asked now) - twin(boom tip, recorded payout)

Errors of boom tip, disturbance and noise are in both twins and cancel to first order; the same orders as in the record
give its readings back to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
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
from winch_controller_node.interface.readings import Measurements, Outputs, ScalarReading, WinchOrder, WinchReading
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


def twin_stepper(line: AxialLine, length: float, start: Iterable[float], tick_period: float) -> AxialStepper:
    """Return the twin of cable and unit.

    Parameters
    ----------
    line : cable and unit
    length : unstretched cable at payout 0 [m]
    start : heave and its rate of the boom tip, payout and its rate at the first tick [m], [m/s]
    tick_period : [s]
    """
    return AxialStepper(line, length, AxialInput(*start), segments=SEGMENTS, duration=tick_period, substeps=SUBSTEPS)


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


def driven(drive: Drive) -> PlantMotion:
    """Return the motion of a plant under its `drive`."""
    rows = np.column_stack((drive.tip.heave, drive.tip.rate, drive.payout, drive.rate))
    stepper = twin_stepper(drive.line, drive.length, rows[0], drive.tick_period)
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


def command_of(order: WinchOrder | None) -> WinchCommand | None:
    """Return the command that an `order` of a controller is; None: there was none."""
    return None if order is None else WinchCommand(order.sequence, order.payout, order.payout_rate, order.brake)


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
        state = twin.step(record.first + index, command_of(record.orders[index]), record.tension[index])
        states[index + 1] = state.payout, state.payout_rate, state.encoder_payout
    modelled, rate, as_read = states.T.copy()
    # what stands above the encoder's noise is what the model of the winch misses
    found = smoothed(record.encoder / encoder_scale - as_read, dt)
    missed, waves = found.values, found.omega > SLOWEST
    error = math.sqrt(float(np.sum((found.kept**2 * found.power)[waves])) / record.ticks)
    return PastWinch(parameters, modelled + missed, rate + np.gradient(missed, dt), modelled, rate, error)


class Core:
    """A controller that steps where that of a `record` did, and is given an adviser's answers that came in time there.

    Parameters
    ----------
    record : whose ticks are stepped through
    parameters : nominal, of the controller
    has_adviser : it has one

    Attributes
    ----------
    beliefs : newest answer of the adviser that came in time
    """

    def __init__(self, record: SensorRecord, parameters: WinchControllerParameters, *, has_adviser: bool) -> None:
        dt, self._record = record.tick_period, record
        self._controller = WinchController(parameters, tick_period=dt)
        self._controller.skip_programme((record.first - 1) * dt)
        self._adviser = Adviser(parameters, tick_period=dt) if has_adviser else None
        self._outputs: Outputs | None = None
        self.beliefs = Beliefs(asked=-1)

    def step(self, index: int, given: Measurements) -> tuple[Outputs, WinchOrder | None]:
        """Do the tick of an `index` with what is `given`; return what came of it, and the order, None in one left out.

        What came of a tick that is left out is that of the tick before, without its alarms.
        """
        tick = self._record.first + index
        if self._outputs is not None and self._record.orders[index] is None:
            self._controller.leave_out(tick)
            self._outputs = self._outputs._replace(alarms=(), observations=None)
            return self._outputs, None
        self._outputs = outputs = self._controller.step(tick, given)
        observed = outputs.observations
        if observed is not None and self._adviser is not None:
            beliefs = self._adviser.advise(observed)
            if observed.last not in self._record.late:
                self.beliefs = beliefs
                self._controller.take(beliefs)
        return outputs, outputs.order


REPRODUCED = 1e-9
"""Orders that differ by less are the same [m/s]."""


@dataclass(frozen=True)
class Again:
    """What the same controller makes of a record."""

    beliefs: Beliefs  # of the adviser at the end; nominal where there was none
    # time at which its orders or its mode are first other than those of the record [s]; infinite: never; NaN: not
    # asked, as the record's controller was another one
    parted: float
    mode: str = ""  # mode there
    was: str = ""  # mode in the record
    alarms: tuple[tuple[float, Alarm], ...] = field(default=(), repr=False)  # that it raised, with their times [s]

    @property
    def is_same(self) -> bool:
        """Return whether every order was given again."""
        return math.isinf(self.parted)


def observed_again(record: SensorRecord, parameters: WinchControllerParameters) -> Again:
    """Have a controller of the active `parameters` read a `record` as it stands.

    Parameters
    ----------
    record : of the sensors
    parameters : nominal, of the run
    """
    core = Core(record, parameters, has_adviser=record.has_adviser)
    parted, mode, was = math.inf, "", ""
    alarms: list[tuple[float, Alarm]] = []
    for index, given in enumerate(record.measurements):
        outputs, order = core.step(index, given)
        alarms += [(float(record.time[index]), alarm) for alarm in outputs.alarms]
        ordered = record.orders[index]
        is_other = (order is not None and ordered is not None) and (
            order.brake != ordered.brake or not abs(order.payout_rate - ordered.payout_rate) <= REPRODUCED
        )
        if is_other and math.isinf(parted):
            parted, mode, was = float(record.time[index]), outputs.mode, record.modes[index]
    return Again(core.beliefs, parted, mode, was, tuple(alarms))


@dataclass(frozen=True)
class Past:
    """What a record has become: everything that another loop is closed over."""

    record: SensorRecord  # of the sensors
    line: AxialLine  # cable and unit as identified
    length: float  # of the cable at payout 0 [m]
    tip: Tip  # the boom tip
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

    name: str  # of it, for tables
    controller: WinchControllerParameters  # parameters of the controller
    winch: WinchParameters | None = None  # parameters of the winch; None: as it is
    has_adviser: bool = True  # the loop identifies what is other than nominal, as on a ship


COLUMNS = 6
"""Columns of the table of a replay: payout, rate, set point, heave of the unit, tension, limits hit."""


class Replay:
    """A loop over a record; `step` does one tick.

    Parameters
    ----------
    past : the record and its twins; None of the twins is asked while the orders are those of the record
    asked : what is tried in it
    """

    def __init__(self, past: Past, asked: Asked) -> None:
        record = past.record
        dt, self._past, self._index = record.tick_period, past, 0
        self._core = Core(record, asked.controller, has_adviser=asked.has_adviser)
        self._winch = VirtualWinch(asked.winch or past.winch_parameters, tick_period=dt)
        self._is_other = asked.winch is not None and asked.winch != past.winch_parameters
        payout, rate = float(past.winch.payout[0]), float(past.winch.rate[0])
        start = (past.tip.heave[0], past.tip.rate[0], payout, rate)
        self._plant = twin_stepper(past.line, past.length, start, dt)
        # differences of the twins at each tick: heave, velocity and acceleration of the unit, tension, payout, its rate
        self._differences = np.zeros((record.ticks, 6))
        self._payout, self._rate = payout, rate

    def step(self) -> tuple[Outputs, Array]:
        """Do one tick; return what the controller gave and the row of it, `COLUMNS` of them."""
        index, past = self._index, self._past
        tick = past.record.first + index
        given = past.record.measurements[index]
        outputs, order = self._core.step(index, self._as_read(given, index) if self._is_other else given)
        was = past.record.orders[index]
        self._is_other |= was is not None and order is not None and order != was
        unit, _, tension, _ = self._plant.state
        limits = self._winch.state.limits_hit if self._is_other else past.record.limits_hit[index]
        row = np.array([self._payout, self._rate, outputs.depth_set_point, unit, tension, int(limits)])
        if index + 1 < past.record.ticks:
            self._advance(self._winch.step(tick, command_of(order), tension), index + 1)
        self._index += 1
        return outputs, row

    def _advance(self, winch: WinchState, index: int) -> None:
        """Take the plant to the next tick, of an `index`, under what the winch has become, and note the differences."""
        past = self._past
        is_other = self._is_other
        extra = winch.payout - past.winch.modelled[index] if is_other else 0.0
        extra_rate = winch.payout_rate - past.winch.modelled_rate[index] if is_other else 0.0
        self._payout, self._rate = past.winch.payout[index] + extra, past.winch.rate[index] + extra_rate
        heave, heave_rate = float(past.tip.heave[index]), float(past.tip.rate[index])
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
    loop, ticks = Replay(past, asked), past.record.ticks
    table = np.empty((ticks, COLUMNS))
    modes: list[str] = []
    alarms: list[tuple[float, Alarm]] = []
    for index in range(ticks):
        outputs, table[index] = loop.step()
        modes.append(outputs.mode)
        alarms += [(float(past.record.time[index]), alarm) for alarm in outputs.alarms]
    payout, rate, set_point, unit, tension, limits = table.T.copy()
    return Replayed(
        past.record.time,
        payout,
        rate,
        set_point,
        unit,
        tension,
        tuple(modes),
        tuple(alarms),
        limits.astype(int),
    )


def locked(record: SensorRecord, drive: Drive) -> Replayed:
    """Return what the winch at its mean payout would have been in a `record`, under that `drive`."""
    ticks, set_point, motion = record.ticks, drive.payout, driven(drive)
    return Replayed(
        record.time,
        set_point,
        drive.rate,
        set_point,
        motion.unit,
        motion.tension,
        ("off",) * ticks,
        (),
        np.zeros(ticks, dtype=int),
    )
