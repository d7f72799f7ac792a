"""The winch of a record: how it answered what it was ordered, and how it or another one would answer other orders."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from cable_sim_node.winch.command_line import WinchCommand
from cable_sim_node.winch.component import VirtualWinch
from cable_sim_node.winch.parameters import EncoderParameters, WinchParameters
from heave_core.servo import NO_POWER_LIMIT
from heave_node.numerics.arrays import Array
from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.beliefs.drum import drum_of
from winch_controller_node.interface.readings import WinchOrder
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.whatif.signals.record import SensorRecord
from heave_studies.whatif.signals.smoother import smoothed
from heave_studies.whatif.signals.tip import SLOWEST


def winch_under(beliefs: Beliefs, nominal: WinchControllerParameters) -> WinchParameters:
    """Return the winch that the `nominal` parameters name, with what `beliefs` say otherwise."""
    assumed = {name: belief.value for name, belief in beliefs.values.items()}
    drum, winch = drum_of(nominal.winch, assumed), nominal.winch
    speed, acceleration = max(drum.speed_out, drum.speed_in), max(drum.acceleration_out, drum.acceleration_in)
    return WinchParameters(
        law=winch.law,
        time_constant=drum.lag,
        position_gain=winch.position_gain,
        position_rate=winch.position_rate,
        command_delay=max(drum.delay, 0.0),
        speed_limit=speed,
        acceleration_limit=acceleration,
        stop_deceleration=min(acceleration, WinchParameters().stop_deceleration),
        hauling_speed_share=max(min(drum.speed_in / speed, 1.0), 0.05),
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
    return PastWinch(modelled + missed, rate + np.gradient(missed, dt), modelled, rate, error)
