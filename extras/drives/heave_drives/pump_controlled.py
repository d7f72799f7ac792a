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

from heave_drives.compiled_drive import CompiledDrive
from heave_drives.kernels import pump as kernel
from heave_drives.kernels.mechanics import NO_LIMIT, RATE, Order, bounds_of, friction_of
from heave_drives.parameters import PumpDriveParameters

SUBSTEP = 0.01
"""Substep over the shortest time constant."""


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
        self._bounds = bounds_of(p.motion)
        self._friction = friction_of(p.friction)
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
