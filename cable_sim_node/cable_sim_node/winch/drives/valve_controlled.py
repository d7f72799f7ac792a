"""The hydraulic winch under servo valves: fixed motors between two lines, constant-pressure supply or accumulator.

With A the flow of the motors per rope speed, a and b the pressures in the lines (a pays out), x the spool over full and
s the pressure of the supply:

    V/E(a) a' = q_a - A v - c (a - b)          q_a = k x root(s - a)   or  k x root(a)   for x above or below 0
    V/E(b) b' = q_b + A v + c (a - b)          q_b = -k x root(b)      or  -k x root(s - b)
    x'' = w^2 (x_set - x) - 2 zeta w x'        abs(x) <= 1 where it meters
    M v' = A (a - b) + T - R(v)                x_set = g (v_set - v) + f v_set + I

k is the rated flow over the root of the rated pressure drop per edge, E(p) the bulk modulus of oil with trapped air.
The supply holds its pressure; or it is a pressure-compensated pump (lag, largest flow, droop) with an adiabatic gas
accumulator and a relief valve at the set pressure.

Integrated by the classical Runge-Kutta scheme (fourth order). The substep is a tenth of the shortest time constant of
valve and motion, and no longer than that of a line behind a fully open edge, which stability needs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from heave_node.parameters import group, parameter

from cable_sim_node.winch.drives import valve_kernel as kernel
from cable_sim_node.winch.drives.compiled_drive import CompiledDrive
from cable_sim_node.winch.drives.mechanics import RATE, Order
from cable_sim_node.winch.drives.motion_parameters import FrictionParameters, MotionParameters

SUBSTEP = 0.1
"""Substep over the shortest time constant."""


@dataclass(frozen=True)
class FluidParameters:
    """Oil in the lines between valve and motors."""

    bulk_modulus: float = parameter(
        1.1e9, unit="Pa", minimum=1e6, maximum=1e11, description="Bulk modulus of the oil alone."
    )
    trapped_air: float = parameter(
        0.005, unit="", minimum=0.0, maximum=0.5, description="Volume fraction of air, at atmospheric pressure."
    )
    line_volume: float = parameter(
        6e-4, unit="m^3", minimum=1e-6, maximum=10.0, description="Volume of each of the two lines, valve to motors."
    )
    leakage: float = parameter(
        1e-11,
        unit="m^3/s/Pa",
        minimum=0.0,
        maximum=1e-6,
        description="Leakage of the motors per unit pressure difference.",
    )


@dataclass(frozen=True)
class ServoValveParameters:
    """All servo valves together, on one set-point."""

    rated_flow: float = parameter(
        800.0 / 6e4,
        unit="m^3/s",
        minimum=1e-6,
        maximum=10.0,
        description="Flow at the rated pressure drop, fully open.",
    )
    rated_drop: float = parameter(
        35e5, unit="Pa", minimum=1e3, maximum=1e8, description="Rated pressure drop across one control edge."
    )
    frequency: float = parameter(
        314.159, unit="rad/s", minimum=1.0, maximum=1e4, description="Natural frequency of the spool."
    )
    damping: float = parameter(1.0, unit="", minimum=0.05, maximum=5.0, description="Damping ratio of the spool.")
    input_limit: float = parameter(
        1.0, unit="", minimum=1.0, maximum=1e6, description="Largest spool set-point, as a fraction of full stroke."
    )
    laminar_pressure: float = parameter(
        5e4,
        unit="Pa",
        minimum=100.0,
        maximum=1e7,
        description="Pressure drop below which the flow of an edge is linear in it.",
    )


@dataclass(frozen=True)
class SupplyParameters:
    """The hydraulic power unit."""

    pressure: float = parameter(24e6, unit="Pa", minimum=1e5, maximum=1e8, description="Set pressure of the unit.")
    accumulator_volume: float = parameter(
        0.0, unit="m^3", minimum=0.0, maximum=100.0, description="Gas volume at precharge; 0: constant supply pressure."
    )
    precharge: float = parameter(
        16e6, unit="Pa", minimum=1e5, maximum=1e8, description="Gas pressure of the empty accumulator."
    )
    pump_flow: float = parameter(
        2000.0 / 6e4,
        unit="m^3/s",
        minimum=1e-6,
        maximum=10.0,
        description="Largest pump flow; used with an accumulator.",
    )
    pump_rate: float = parameter(
        6.0,
        unit="1/s",
        minimum=0.01,
        maximum=1e3,
        description="Bandwidth of the pump flow (reciprocal of its time constant).",
    )
    droop: float = parameter(
        1e6,
        unit="Pa",
        minimum=1e3,
        maximum=1e8,
        description="Pressure drop below the set pressure at which the pump delivers its full flow.",
    )

    def __post_init__(self) -> None:
        if self.accumulator_volume > 0.0 and self.precharge >= self.pressure:
            raise ValueError(
                f"supply.precharge = {self.precharge:g} Pa must be below supply.pressure = {self.pressure:g} Pa"
            )


@dataclass(frozen=True)
class ValveDriveParameters:
    """A valve-controlled hydraulic winch drive. The defaults are a drawworks of 24 t on six parts of rope."""

    motion: MotionParameters = group(MotionParameters, speed_limit=1.2)
    friction: FrictionParameters = group(FrictionParameters, load=0.15, slip_speed=0.008)
    fluid: FluidParameters = group(FluidParameters)
    valve: ServoValveParameters = group(ServoValveParameters)
    supply: SupplyParameters = group(SupplyParameters)
    motor_displacement: float = parameter(
        3e-5, unit="m^3/rad", minimum=1e-9, maximum=1.0, description="Displacement of all motors together."
    )
    motor_radians_per_metre: float = parameter(
        600.0, unit="rad/m", minimum=0.1, maximum=1e6, description="Motor rotation per metre of payout."
    )
    motor_inertia: float = parameter(
        0.01,
        unit="kg m^2",
        minimum=1e-9,
        maximum=1e5,
        description="Inertia of all motors and everything that turns with them.",
    )
    load_mass: float = parameter(
        0.0,
        unit="kg",
        minimum=0.0,
        maximum=1e8,
        description="Mass moving rigidly with the rope; its weight is part of the tension.",
    )
    gain: float = parameter(
        0.1,
        unit="s/m",
        minimum=0.0,
        maximum=1e4,
        description="Gain of the speed loop: spool position (fraction of full) per speed error.",
    )
    feed_forward: float = parameter(
        1.0,
        unit="s/m",
        minimum=0.0,
        maximum=1e3,
        description="Feed-forward: spool position (fraction of full) per speed set-point.",
    )
    integral_time: float = parameter(
        0.01, unit="s", minimum=1e-3, maximum=1e9, description="Integral time of the speed loop."
    )

    @property
    def area(self) -> float:
        """A: flow of the motors per rope speed, force per pressure [m^2]."""
        return self.motor_displacement * self.motor_radians_per_metre

    @property
    def mass(self) -> float:
        """M: mass that the rope feels [kg]."""
        return self.motor_inertia * self.motor_radians_per_metre**2 + self.load_mass


class ValveDrive(CompiledDrive):
    """The drive, at rest with its fluid carrying the first tension and its accumulator full.

    Parameters
    ----------
    parameters : the drive
    tension : at the start [N]

    Raises ValueError where the supply cannot hold that tension.
    """

    def __init__(self, parameters: ValveDriveParameters, *, tension: float = 0.0) -> None:
        p = parameters
        super().__init__(kernel.SIZE, SUBSTEP, p.motion.position_gain)
        self._parameters = p
        self._bounds = p.motion.bounds()
        self._friction = p.friction.friction()
        self._fluid = kernel.Fluid(p.fluid.bulk_modulus, p.fluid.trapped_air)
        self._plant = _plant(p)
        held = tension / p.area
        if abs(held) > p.supply.pressure:
            raise ValueError(f"{tension:g} N needs {held:g} Pa; the supply has {p.supply.pressure:g} Pa")
        x = self._x
        x[kernel.PRESSURE_A] = 0.5 * (p.supply.pressure - held)
        x[kernel.PRESSURE_B] = 0.5 * (p.supply.pressure + held)
        x[kernel.OIL] = self._plant.fullest
        self._stored_at_start = self._stored()

    def instruments(self) -> Mapping[str, float]:
        """Return spool over full [-], pressures of the lines and of the supply [Pa], flow drawn [m^3/s]."""
        x = self._x
        return {
            "spool": min(max(float(x[kernel.SPOOL]), -1.0), 1.0),
            "pressure_a_pa": float(x[kernel.PRESSURE_A]),
            "pressure_b_pa": float(x[kernel.PRESSURE_B]),
            "supply_pressure_pa": float(kernel.pressure_of_supply(x, self._plant)),
            "flow_m3ps": float(kernel.drawn_flow(x, self._plant)),
        }

    def _fastest_rate(self, tension: float) -> float:
        p, plant = self._parameters, self._plant
        stiffness = p.fluid.bulk_modulus / p.fluid.line_volume
        motion = plant.area * math.sqrt(2.0 * stiffness / plant.mass)
        edge = plant.valve_gain / math.sqrt(plant.laminar_pressure) * stiffness
        friction = p.friction.rate(tension, plant.mass)
        return max(p.valve.frequency, motion, friction, 1.0 / p.integral_time, SUBSTEP * edge)

    def _advance(self, order: Order, tension: float, substeps: int, h: float) -> tuple[float, int]:
        return kernel.advance_valve(
            self._x,
            self._work,
            self._plant,
            self._fluid,
            self._friction,
            self._bounds,
            order,
            tension,
            substeps,
            h,
        )

    def _stored(self) -> float:
        x, volume = self._x, self._plant.line_volume
        fluid = sum(
            kernel.fluid_energy(x[line], volume, self._fluid) for line in (kernel.PRESSURE_A, kernel.PRESSURE_B)
        )
        gas = kernel.accumulator_energy(x, self._plant)
        return float(0.5 * self._plant.mass * x[RATE] ** 2 + fluid + gas)


def _oil_when_full(supply: SupplyParameters) -> float:
    """Return the oil in the accumulator at the supply's set pressure [m^3]."""
    share = (supply.precharge / supply.pressure) ** (1.0 / kernel.GAS_EXPONENT)
    return supply.accumulator_volume * (1.0 - share) if supply.accumulator_volume > 0.0 else 0.0


def _plant(p: ValveDriveParameters) -> kernel.ValvePlant:
    return kernel.ValvePlant(
        mass=p.mass,
        area=p.area,
        line_volume=p.fluid.line_volume,
        leakage=p.fluid.leakage,
        valve_gain=p.valve.rated_flow / math.sqrt(p.valve.rated_drop),
        valve_frequency=p.valve.frequency,
        valve_damping=p.valve.damping,
        spool_input_limit=p.valve.input_limit,
        laminar_pressure=p.valve.laminar_pressure,
        gain=p.gain,
        feed_forward=p.feed_forward,
        integral_time=p.integral_time,
        supply_pressure=p.supply.pressure,
        pump_flow=p.supply.pump_flow,
        pump_rate=p.supply.pump_rate,
        droop=p.supply.droop,
        accumulator_volume=p.supply.accumulator_volume,
        precharge=p.supply.precharge,
        fullest=_oil_when_full(p.supply),
    )
