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

from heave_drives.compiled_drive import CompiledDrive
from heave_drives.kernels import valve as kernel
from heave_drives.kernels.mechanics import RATE, Order, bounds_of, friction_of
from heave_drives.parameters import SupplyParameters, ValveDriveParameters

SUBSTEP = 0.1
"""Substep over the shortest time constant."""


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
        self._bounds = bounds_of(p.motion)
        self._friction = friction_of(p.friction)
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
    precharge, pressure = supply.precharge + kernel.ATMOSPHERE, supply.pressure + kernel.ATMOSPHERE
    share = (precharge / pressure) ** (1.0 / kernel.GAS_EXPONENT)
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
