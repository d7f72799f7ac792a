"""Drives that are published with all their numbers, as instances of the models here."""

from __future__ import annotations

import math

from heave_drives.parameters import (
    FluidParameters,
    FrictionParameters,
    MotionParameters,
    PumpDriveParameters,
    ServoValveParameters,
    SupplyParameters,
    ValveDriveParameters,
)

LITRES_PER_MINUTE = 1e-3 / 60.0
"""[m^3/s]."""


def zinage_drive() -> PumpDriveParameters:
    """Return the hydraulic winch of Zinage & Somayajula (2020), a load of 1 t rigid with the rope.

    Its state space is linear but for the swash, which ends at full. The input may be 200 times full swash; no relief
    valve, no speed limit. The load's weight is balanced: the tension is what comes on top of it.
    """
    radius, viscous = 0.5, 1e4
    return PumpDriveParameters(
        motion=MotionParameters(speed_limit=1.125, overspeed=0.0, payout_minimum=-1000.0, payout_maximum=1000.0),
        friction=FrictionParameters(viscous=viscous / radius**2),
        drum_radius=radius,
        drum_inertia=150.0,
        load_mass=1000.0,
        gear_ratio=200.0,
        motor_displacement=4e-6,
        motor_efficiency=0.65,
        is_passive=False,
        pump_displacement=40e-6,
        pump_speed=45.0,
        swash_time_constant=1.0,
        swash_input_limit=200.0,
        bulk_modulus=1.8e9,
        line_volume=2e-3,
        leakage=0.0,
        relief_pressure=0.0,
        gain=0.0,
    )


def mas410_radians_per_metre(sheaves: int, gear: float) -> float:
    """Return the turn of the motors per metre of the payload [rad/m], with n_sh `sheaves` and a `gear` of ratio i_g.

    4 n_sh d_R i_g/(d_D d_P) of the drawworks of course MAS410 (University of Agder): drum 0.45 m, gear rim 0.5 m,
    pinion 0.15 m.
    """
    return 4.0 * sheaves * 0.5 * gear / (0.45 * 0.15)


def mas410_published_solution() -> ValveDriveParameters:
    """Return the drive of a published solution of the course project MAS410 (University of Agder, 2023).

    18 t, 2 sheaves, gear 11, five motors of 16 cm^3, four servo valves of 200 l/min (50 Hz, damping 1), 250 bar, and
    the speed loop of its control system. Two things are as its model has them, not as they should be: the payload's
    inertia is m (d_D/2)^2 n^-2 at the motors (metres squared too small), and the friction's tanh takes the payload's
    speed for the motors'.
    """
    n = mas410_radians_per_metre(2, 11.0)
    displacement = 5.0 * 16e-6 / (2.0 * math.pi)
    nominal_speed = 8000.0 * 2.0 * math.pi / 60.0
    valves, edge_area = 4.0, 200.0 * LITRES_PER_MINUTE / (0.7 * math.sqrt(2.0 / 875.0 * 35e5))
    return ValveDriveParameters(
        motion=MotionParameters(speed_limit=100.0, overspeed=0.0, payout_minimum=-1000.0, payout_maximum=1000.0),
        friction=FrictionParameters(load=0.15, slip_speed=5.0),
        fluid=FluidParameters(
            bulk_modulus=1.1e9,
            trapped_air=0.005,
            line_volume=0.6e-3,
            # volumetric efficiency 0.92 at 100 bar and nominal speed with an oil of 900 kg/m^3; this one has 875
            leakage=displacement * nominal_speed * 0.08 / 100e5 * 900.0 / 875.0,
        ),
        valve=ServoValveParameters(
            rated_flow=valves * 200.0 * LITRES_PER_MINUTE,
            rated_drop=35e5,
            frequency=2.0 * math.pi * 50.0,
            damping=1.0,
            input_limit=1e6,
        ),
        supply=SupplyParameters(pressure=250e5),
        motor_displacement=displacement,
        motor_radians_per_metre=n,
        motor_inertia=5.0 * 0.0004,
        load_mass=18_000.0 * (0.45 / 2.0) ** 2,
        # 4000/n_v (39.93 mm^2/A_d), and the valve's transfer function has 1/omega for its gain
        gain=4000.0 / valves * 39.93e-6 / edge_area / (2.0 * math.pi * 50.0),
        feed_forward=0.0,
        integral_time=1e9,
    )
