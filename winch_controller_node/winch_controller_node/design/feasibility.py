"""What a sea asks of a winch (thesis 6.5): speed, acceleration, torque and power, as a table for its buyer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from cable_sim_node.vertical.linear import heave_transfer_function
from heave_node.numerics.arrays import Array

from winch_controller_node.design.design import assumed_plant
from winch_controller_node.model.models import boom_tip_response, sea_spectrum
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import SeaModelParameters, VesselModelParameters

BAND = 5.0
"""Upper end of the band that counts [rad/s]; a spectrum's tail above it moves no vessel."""

POINTS = 4000
GAUSSIAN_TO_HARMONIC = math.sqrt(8.0 / math.pi) * 3.0 * math.pi / 8.0
"""Harmonic amplitude over Gaussian sigma at equal linearised quadratic drag."""

DRUM_RADIUS = 0.75
"""Radius at which torque is stated where none is given [m]."""

STORM = 3.0 * 3600.0
"""Duration over which the largest values are expected [s]."""


@dataclass(frozen=True)
class WinchDemand:
    """What full compensation of one sea asks of the winch. Largest: the expected maximum of three hours (Rayleigh)."""

    significant_wave_height: float  # of the sea [m]
    peak_period: float  # of the sea [s]
    stroke: float  # largest payout either way [m]
    speed: float  # largest payout rate [m/s]
    acceleration: float  # largest payout acceleration [m/s^2]
    torque: float  # static tension at the drum radius [N m]; the drum's own inertia comes on top
    power: float  # static tension times the largest speed [W]
    mean_hauling_power: float  # static tension times the mean speed while hauling [W]
    within_limits: bool  # the assumed winch can do it


def boom_tip_density(sea: SeaModelParameters, vessel: VesselModelParameters, omega: Array) -> Array:
    """Return the one-sided spectrum of the boom-tip heave of a `vessel` in a `sea`, of the shape of `omega`.

    From the spectrum itself, not from the shaping filter that models it; [m^2 s/rad] at `omega` [rad/s].
    """
    response = boom_tip_response(sea, vessel, omega)
    return np.asarray(sea_spectrum(sea).density(omega) * np.abs(response) ** 2)


def boom_tip_moments(sea: SeaModelParameters, vessel: VesselModelParameters) -> tuple[float, float, float]:
    """Return the variances of the boom tip's heave [m^2], rate and acceleration, by quadrature up to 5 rad/s.

    `sea` and `vessel` are assumed.
    """
    omega = np.linspace(1e-3, BAND, POINTS)
    density = boom_tip_density(sea, vessel, omega)
    m0, m2, m4 = (float(np.sum(density * omega**power) * (omega[1] - omega[0])) for power in (0, 2, 4))
    return m0, m2, m4


def uncompensated_sigma(parameters: WinchControllerParameters, length: float) -> float:
    """Return the standard deviation of unit heave with the winch locked [m], at a `length` [m].

    The sea is that of `parameters`, the cable exact. Drag is linearised at the harmonic amplitude that dissipates as
    much as the Gaussian sea, sqrt(8/pi) / (8/(3 pi)) sigma. The compensated loop's own model is not fit for this: it is
    linearised about the small motion it leaves.
    """
    plant = assumed_plant(parameters)
    omega = np.linspace(0.05, BAND, 400)
    density = boom_tip_density(parameters.sea, parameters.vessel, omega)
    step = omega[1] - omega[0]
    amplitude = GAUSSIAN_TO_HARMONIC * math.sqrt(float(np.sum(density)) * step)
    transfer = heave_transfer_function(plant.line(length), length, omega, amplitude=amplitude)
    return math.sqrt(float(np.sum(np.abs(transfer.unit_heave) ** 2 * density)) * step)


def winch_demand(parameters: WinchControllerParameters, *, tension: float, drum_radius: float) -> WinchDemand:
    """Return what full compensation of the sea of `parameters` asks of the winch.

    `tension` is the static one at the top [N]: compensated, the unit hangs still and the cable in the water hardly
    moves. `drum_radius` [m] gives the torque.
    """
    m0, m2, m4 = boom_tip_moments(parameters.sea, parameters.vessel)
    cycles = STORM * math.sqrt(m2 / m0) / (2.0 * math.pi)
    largest = math.sqrt(2.0 * math.log(cycles))
    stroke, speed, acceleration = (largest * math.sqrt(m) for m in (m0, m2, m4))
    winch = parameters.winch
    power = tension * speed
    return WinchDemand(
        significant_wave_height=parameters.sea.significant_wave_height,
        peak_period=parameters.sea.peak_period,
        stroke=stroke,
        speed=speed,
        acceleration=acceleration,
        torque=tension * drum_radius,
        power=power,
        mean_hauling_power=tension * math.sqrt(2.0 * m2 / math.pi),
        within_limits=bool(
            speed <= winch.speed_limit
            and acceleration <= winch.acceleration_limit
            and stroke <= min(-winch.payout_minimum, winch.payout_maximum)
            and (winch.power_limit == 0.0 or power <= winch.power_limit)
        ),
    )


def feasibility_table(
    parameters: WinchControllerParameters,
    heights: Sequence[float],
    periods: Sequence[float],
    *,
    drum_radius: float = DRUM_RADIUS,
) -> list[WinchDemand]:
    """Return the demand for each significant wave height of `heights` [m] and peak period of `periods` [s].

    The rest of the sea is that of `parameters`; `drum_radius` [m] gives the torque.
    """
    plant = assumed_plant(parameters)
    tension = plant.line(parameters.length).static_top_tension(parameters.length)
    rows = []
    for height in heights:
        for period in periods:
            sea = replace(parameters.sea, significant_wave_height=height, peak_period=period)
            rows.append(winch_demand(replace(parameters, sea=sea), tension=tension, drum_radius=drum_radius))
    return rows


def format_feasibility(rows: Sequence[WinchDemand]) -> str:
    """Return `rows` as a table of text."""
    lines = [
        "Hs m   Tp s  stroke m  speed m/s  accel. m/s2  torque kN m  power kW  mean hauling kW  within the limits",
    ]
    lines += [
        f"{row.significant_wave_height:4.1f}  {row.peak_period:5.1f}  {row.stroke:8.2f}  "
        f"{row.speed:9.2f}  {row.acceleration:11.2f}"
        f"  {row.torque / 1e3:11.1f}  {row.power / 1e3:8.1f}  {row.mean_hauling_power / 1e3:15.1f}  "
        f"{'yes' if row.within_limits else 'no'}"
        for row in rows
    ]
    return "\n".join(lines)
