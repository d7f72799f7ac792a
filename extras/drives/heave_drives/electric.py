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

from heave_drives.compiled_drive import CompiledDrive
from heave_drives.kernels import electric as kernel
from heave_drives.kernels.mechanics import RATE, Order, bounds_of, friction_of
from heave_drives.kernels.spool import make_spool
from heave_drives.parameters import ElectricDriveParameters

SUBSTEP = 0.2
"""Substep over the shortest time constant."""


class ElectricDrive(CompiledDrive):
    """The drive, at rest with its motor carrying the first tension.

    Parameters
    ----------
    parameters : the drive
    tension : at the start [N]

    Raises ValueError where the motor cannot hold that tension.
    """

    def __init__(self, parameters: ElectricDriveParameters, *, tension: float = 0.0) -> None:
        p = parameters
        super().__init__(kernel.SIZE, SUBSTEP, p.motion.position_gain)
        self._parameters = p
        self._spool = make_spool(p.spool, p.motion.payout_minimum, p.motion.payout_maximum)
        self._bounds = bounds_of(p.motion)
        self._friction = friction_of(p.friction)
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
        held = tension / kernel.motor(self._x, self._plant, self._spool)[0]
        if abs(held) > p.torque_limit:
            raise ValueError(f"{tension:g} N needs {held:g} N m of the motor; torque_limit is {p.torque_limit:g} N m")
        self._x[kernel.TORQUE] = -held

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
