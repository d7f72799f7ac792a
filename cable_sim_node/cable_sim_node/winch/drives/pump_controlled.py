"""The hydrostatic winch: a swash-plate pump in a closed circuit with motors of fixed or variable displacement.

With x the swash over full, y the motors' displacement over full, p the pressure that hoists, Q the pump's flow at full
swash and A = D_m K/r the flow of the motors per rope speed (an equivalent piston), rope rate v positive paying out:

    x' = (u - x)/T_p,                 |x| <= 1
    p' = 2 k_b/V_c (A y v - Q x - c p),   |p| <= relief pressure
    M v' = -eta A y p + T - R(v)

A relief valve and a power limit of the prime mover (abs(p Q x)) may act. The input u is
v_set y/v_full + k (v_set - v)/v_full + I with v_full = Q/A; it may be far above 1, which drives the swash's lag harder.
Motors of variable displacement give way to speed: y follows v_full/|v_set|, down to motor_minimum.

With constant efficiency eta (`is_passive` false), no leakage, no gain and the numbers of `published.zinage_drive` it is
the state space of Zinage & Somayajula, Ocean Systems Engineering 10(4), 2020 (their reeled length is measured in the
direction that positive swash turns). That efficiency is as printed: where the load drives the motor it would give more
power than comes in. With `is_passive` the same share (1 - eta) of the pressure's force is friction, against the motion.

Integrated by the classical Runge-Kutta scheme (fourth order), substeps of a hundredth of the shortest time constant.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from heave_node.parameters import group, parameter

from cable_sim_node.winch.drives import pump_kernel as kernel
from cable_sim_node.winch.drives.compiled_drive import CompiledDrive
from cable_sim_node.winch.drives.mechanics import NO_LIMIT, RATE, Order
from cable_sim_node.winch.drives.motion_parameters import FrictionParameters, MotionParameters

SUBSTEP = 0.01
"""Substep over the shortest time constant."""


@dataclass(frozen=True)
class PumpDriveParameters:
    """A pump-controlled hydraulic winch drive. The defaults are a 10 t winch."""

    motion: MotionParameters = group(MotionParameters, speed_limit=1.5)
    friction: FrictionParameters = group(FrictionParameters, coulomb=1e3, slip_speed=0.05, viscous=2e3)
    drum_radius: float = parameter(
        0.5, unit="m", minimum=0.01, maximum=20.0, description="Radius from the drum's axis to the rope."
    )
    drum_inertia: float = parameter(
        500.0, unit="kg m^2", minimum=1e-6, maximum=1e7, description="Inertia about the drum's axis, motors included."
    )
    load_mass: float = parameter(
        0.0,
        unit="kg",
        minimum=0.0,
        maximum=1e8,
        description="Mass moving rigidly with the rope that the tension does not include.",
    )
    gear_ratio: float = parameter(50.0, unit="", minimum=0.1, maximum=1e4, description="K: motor turns per drum turn.")
    motor_displacement: float = parameter(
        5e-5,
        unit="m^3/rad",
        minimum=1e-9,
        maximum=1.0,
        description="D_m: displacement of all motors together, at full stroke.",
    )
    motor_minimum: float = parameter(
        1.0,
        unit="",
        minimum=0.05,
        maximum=1.0,
        description="Smallest displacement as a fraction of full displacement; 1 is a fixed-displacement motor.",
    )
    motor_time_constant: float = parameter(
        0.1, unit="s", minimum=1e-3, maximum=60.0, description="Time constant of the motors' displacement."
    )
    motor_efficiency: float = parameter(
        0.92, unit="", minimum=0.05, maximum=1.0, description="eta: mechanical efficiency of motors and gear."
    )
    is_passive: bool = parameter(
        True, unit="", description="Losses from efficiency act as friction; false: as a constant factor, as published."
    )
    pump_displacement: float = parameter(
        5e-5,
        unit="m^3/rad",
        minimum=1e-9,
        maximum=1.0,
        description="D_p: displacement of all pumps together, at full swash.",
    )
    pump_speed: float = parameter(
        150.0, unit="rad/s", minimum=0.1, maximum=1e4, description="w_p: speed of the pump shaft."
    )
    swash_time_constant: float = parameter(
        0.1, unit="s", minimum=1e-3, maximum=60.0, description="T_p: time constant of the swash plate."
    )
    swash_input_limit: float = parameter(
        5.0,
        unit="",
        minimum=1.0,
        maximum=1e4,
        description="Largest input of the swash servo, as a fraction of full swash.",
    )
    bulk_modulus: float = parameter(
        1.2e9, unit="Pa", minimum=1e6, maximum=1e11, description="k_b: bulk modulus of the fluid."
    )
    line_volume: float = parameter(
        5e-3, unit="m^3", minimum=1e-6, maximum=10.0, description="V_c: volume of both lines together."
    )
    leakage: float = parameter(
        3e-11,
        unit="m^3/s/Pa",
        minimum=0.0,
        maximum=1e-6,
        description="c: leakage of pump and motors per unit pressure.",
    )
    relief_pressure: float = parameter(
        35e6,
        unit="Pa",
        minimum=0.0,
        maximum=1e9,
        description="Pressure at which the relief valves open; 0: no relief valves.",
    )
    power_limit: float = parameter(
        0.0, unit="W", minimum=0.0, maximum=1e9, description="Largest hydraulic power of the pump; 0: no limit."
    )
    gain: float = parameter(
        0.5,
        unit="",
        minimum=0.0,
        maximum=1e3,
        description="k: gain of the speed loop, from speed error over v_full to swash.",
    )
    integral_time: float = parameter(
        0.5,
        unit="s",
        minimum=1e-3,
        maximum=1e3,
        description="Integral time of the speed loop; unused if its gain is 0.",
    )

    @property
    def full_speed(self) -> float:
        """Rope speed at full swash and full motor displacement [m/s]."""
        return self.pump_displacement * self.pump_speed / self.area

    @property
    def area(self) -> float:
        """A: flow of the motors per rope speed, force per pressure [m^2]."""
        return self.motor_displacement * self.gear_ratio / self.drum_radius

    @property
    def mass(self) -> float:
        """M: mass that the rope feels [kg]."""
        return self.drum_inertia / self.drum_radius**2 + self.load_mass


class PumpDrive(CompiledDrive):
    """The drive, at rest with its fluid carrying the first tension.

    Parameters
    ----------
    parameters : the drive
    tension : at the start [N]; without the weight of load_mass where that is balanced otherwise

    Raises ValueError where the relief valves would open under that tension.
    """

    def __init__(self, parameters: PumpDriveParameters, *, tension: float = 0.0) -> None:
        p = parameters
        super().__init__(kernel.SIZE, SUBSTEP, p.motion.position_gain)
        self._parameters = p
        self._bounds = p.motion.bounds()
        self._friction = p.friction.friction()
        relief = p.relief_pressure if p.relief_pressure > 0.0 else NO_LIMIT
        self._plant = kernel.PumpPlant(
            mass=p.mass,
            flow=p.pump_displacement * p.pump_speed,
            area=p.area,
            stiffness=2.0 * p.bulk_modulus / p.line_volume,
            swash_time=p.swash_time_constant,
            swash_input_limit=p.swash_input_limit,
            leakage=p.leakage,
            efficiency=p.motor_efficiency,
            is_passive=p.is_passive,
            relief_pressure=relief,
            power_limit=p.power_limit if p.power_limit > 0.0 else NO_LIMIT,
            motor_minimum=p.motor_minimum,
            motor_time=p.motor_time_constant,
            overdrive=p.swash_input_limit,
            gain=p.gain,
            integral_time=p.integral_time,
        )
        held = tension / (p.area * (1.0 if p.is_passive else p.motor_efficiency))
        if abs(held) > relief:
            raise ValueError(f"{tension:g} N needs {held:g} Pa; the relief valves open at {relief:g} Pa")
        self._x[kernel.MOTOR] = 1.0
        self._x[kernel.PRESSURE] = held
        leak = p.leakage * held / (p.pump_displacement * p.pump_speed)
        self._x[kernel.SWASH] = -leak
        self._x[kernel.INTEGRAL] = -leak if p.gain > 0.0 else 0.0
        self._stored_at_start = self._stored()

    def instruments(self) -> Mapping[str, float]:
        """Return swash over full [-], pressure that hoists [Pa] and motor displacement over full [-]."""
        x = self._x
        return {
            "swash": float(x[kernel.SWASH]),
            "pressure_pa": float(x[kernel.PRESSURE]),
            "motor_displacement": float(x[kernel.MOTOR]),
        }

    def _fastest_rate(self, tension: float) -> float:
        p, plant = self._parameters, self._plant
        fluid = plant.area * math.sqrt(plant.stiffness / plant.mass)
        lags = [p.swash_time_constant]
        if p.gain > 0.0:
            lags.append(p.integral_time)
        if p.motor_minimum < 1.0:
            lags.append(p.motor_time_constant)
        return max(fluid, p.leakage * plant.stiffness, 1.0 / min(lags), p.friction.rate(tension, plant.mass))

    def _advance(self, order: Order, tension: float, substeps: int, h: float) -> tuple[float, int]:
        return kernel.advance_pump(
            self._x, self._work, self._plant, self._friction, self._bounds, order, tension, substeps, h
        )

    def _stored(self) -> float:
        x, plant = self._x, self._plant
        return float(0.5 * plant.mass * x[RATE] ** 2 + 0.5 * x[kernel.PRESSURE] ** 2 / plant.stiffness)
