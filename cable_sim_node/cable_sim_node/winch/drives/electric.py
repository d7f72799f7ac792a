"""The electric winch: motor, gear and layered drum under a speed loop, with the tension acting back on them.

With J the inertia at the drum (motor included), rho the arm (metres of payout per radian) and G the gear ratio, the
rope feels M = J/rho^2 + load_mass, and

    M v' + M' v^2/2 = tau G/rho + T - R(v)

tau is the motor's torque. It follows the demand of the loop with a lag (current loop), never beyond the motor's curve:
constant torque up to the corner speed, constant power above. The loop is what drives have: a reference v_r that follows
the set-point within an acceleration limit, and

    tau_asked G/rho = M v_r' + K (v_r - v) + I - f T,    I' = (K (v_r - v) + (tau - tau_asked) G/rho)/T_i

with f the share of the measured tension that is fed forward; the last term of I' is the anti-windup (back-calculation),
which keeps the integral from growing while the torque is at a limit. Under the brake the motor carries the load, so
that the drum does not drop when the brake opens.

Integrated by the classical Runge-Kutta scheme (fourth order) with substeps of a fifth of the shortest time constant.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from heave_node.parameters import group, parameter

from cable_sim_node.winch.drives import electric_kernel as kernel
from cable_sim_node.winch.drives.compiled_drive import CompiledDrive
from cable_sim_node.winch.drives.mechanics import RATE, Order
from cable_sim_node.winch.drives.motion_parameters import FrictionParameters, MotionParameters
from cable_sim_node.winch.drives.spool import SpoolParameters, make_spool

SUBSTEP = 0.2
"""Substep over the shortest time constant."""


@dataclass(frozen=True)
class ElectricDriveParameters:
    """An electric winch drive. The defaults are a 20 t winch of 400 kW."""

    motion: MotionParameters = group(MotionParameters)
    friction: FrictionParameters = group(FrictionParameters, coulomb=1e3, load=0.02, viscous=500.0)
    spool: SpoolParameters = group(SpoolParameters)
    drum_inertia: float = parameter(
        1000.0, unit="kg m^2", minimum=0.0, maximum=1e7, description="Inertia of drum and gear about the drum's axis."
    )
    motor_inertia: float = parameter(
        5.0, unit="kg m^2", minimum=1e-6, maximum=1e5, description="Inertia of all motors about their own axes."
    )
    gear_ratio: float = parameter(40.0, unit="", minimum=0.1, maximum=1e4, description="Motor turns per drum turn.")
    load_mass: float = parameter(
        0.0,
        unit="kg",
        minimum=0.0,
        maximum=1e8,
        description="Mass moving rigidly with the rope that the tension does not include.",
    )
    torque_limit: float = parameter(
        4000.0, unit="N m", minimum=1e-3, maximum=1e8, description="Largest torque of all motors together."
    )
    motoring_power_limit: float = parameter(
        400e3, unit="W", minimum=1.0, maximum=1e9, description="Largest motoring shaft power."
    )
    regeneration_power_limit: float = parameter(
        400e3, unit="W", minimum=1.0, maximum=1e9, description="Largest braking shaft power."
    )
    torque_time_constant: float = parameter(
        0.005, unit="s", minimum=1e-4, maximum=10.0, description="Time constant of the torque (current loop, field)."
    )
    copper_loss: float = parameter(
        10e3, unit="W", minimum=0.0, maximum=1e8, description="Copper loss at torque_limit; proportional to torque^2."
    )
    acceleration_limit: float = parameter(
        1.5, unit="m/s^2", minimum=1e-3, maximum=1e6, description="Largest acceleration of the speed reference."
    )
    reference_time: float = parameter(
        0.05, unit="s", minimum=1e-3, maximum=60.0, description="Time constant of the reference behind the set-point."
    )
    bandwidth: float = parameter(
        20.0, unit="rad/s", minimum=0.1, maximum=1000.0, description="Gain of the speed loop, divided by mass."
    )
    integral_time: float = parameter(
        0.3, unit="s", minimum=1e-3, maximum=1000.0, description="Integral time of the speed loop."
    )
    tension_feed_forward: float = parameter(
        0.0, unit="", minimum=0.0, maximum=1.0, description="Fraction of the measured tension that is fed forward."
    )

    def __post_init__(self) -> None:
        make_spool(self.spool, self.motion.payout_minimum, self.motion.payout_maximum)

    @property
    def inertia(self) -> float:
        """Inertia at the drum, motors included [kg m^2]."""
        return self.drum_inertia + self.gear_ratio**2 * self.motor_inertia


class ElectricDrive(CompiledDrive):
    """The drive, at rest with its motor carrying the first tension.

    Parameters
    ----------
    parameters : the drive
    tension : at the start [N]
    """

    def __init__(self, parameters: ElectricDriveParameters, *, tension: float = 0.0) -> None:
        p = parameters
        super().__init__(kernel.SIZE, SUBSTEP, p.motion.position_gain)
        self._parameters = p
        self._spool = make_spool(p.spool, p.motion.payout_minimum, p.motion.payout_maximum)
        self._bounds = p.motion.bounds()
        self._friction = p.friction.friction()
        self._lightest = p.inertia / (float(self._spool.radius[-1]) / self._spool.falls) ** 2 + p.load_mass
        self._plant = kernel.ElectricPlant(
            inertia=p.inertia,
            load_mass=p.load_mass,
            gear_ratio=p.gear_ratio,
            torque_limit=p.torque_limit,
            motoring_limit=p.motoring_power_limit,
            regeneration_limit=p.regeneration_power_limit,
            torque_time=p.torque_time_constant,
            copper_loss=p.copper_loss,
            acceleration_limit=p.acceleration_limit,
            reference_time=p.reference_time,
            bandwidth=p.bandwidth,
            integral_time=p.integral_time,
            feed_forward=p.tension_feed_forward,
        )
        self._x[kernel.INTEGRAL] = -(1.0 - p.tension_feed_forward) * tension
        self._x[kernel.TORQUE] = -tension / kernel.motor(self._x, self._plant, self._spool)[0]

    def instruments(self) -> Mapping[str, float]:
        """Return motor torque [N m] and motor speed [rad/s]."""
        ratio, torque = kernel.motor(self._x, self._plant, self._spool)
        return {"motor_torque_nm": torque, "motor_speed_radps": ratio * float(self._x[RATE])}

    def _fastest_rate(self, tension: float) -> float:
        p = self._parameters
        lags = min(p.torque_time_constant, p.reference_time, p.integral_time)
        return max(1.0 / lags, p.bandwidth, p.friction.rate(tension, self._lightest))

    def _advance(self, order: Order, tension: float, substeps: int, h: float) -> tuple[float, int]:
        return kernel.advance_electric(
            self._x, self._work, self._plant, self._spool, self._friction, self._bounds, order, tension, substeps, h
        )

    def _stored(self) -> float:
        return float(kernel.kinetic_energy(self._x, self._plant, self._spool))
