"""The published controllers with their published gains, and the inversion that knows the future, for reference."""

from __future__ import annotations

import numpy as np
from cable_sim_node.winch.drives.published import zinage_drive

from heave_bringup.benchmark.interface import Command, Facts, Measurement

INPUT_LIMIT = 200.0
"""Largest input of the published controllers."""


class _OfZinage:
    """What the laws of Zinage & Somayajula (2020) share: their signs, and the input's limit.

    Their reeled length z grows where the payout falls; a swash of 1 is the drive's full speed. The newest readings
    stand until others come.
    """

    def __init__(self, facts: Facts) -> None:
        self._dt = facts.sample_time
        self._full_speed = facts.winch.speed_limit
        self._heave = 0.0

    def _error(self, measurement: Measurement) -> float:
        """Return e = -heave - z [m]."""
        if measurement.mru:
            self._heave = measurement.mru[-1].heave
        return measurement.winch.payout - self._heave

    def _command(self, u: float) -> Command:
        return Command(payout_rate=-self._full_speed * min(max(u, -INPUT_LIMIT), INPUT_LIMIT))


class ZinagePid(_OfZinage):
    """u = 5.86 e + 0.711 int e + 5.46 N s/(s + N) e, N = 33.33 (forward Euler), as published.

    Parameters
    ----------
    facts : of the case
    """

    def __init__(self, facts: Facts) -> None:
        super().__init__(facts)
        self._integral = 0.0
        self._filtered = 0.0

    def step(self, measurement: Measurement) -> Command:
        """See `Controller.step`."""
        e = self._error(measurement)
        slope = 33.33 * (e - self._filtered)
        u = 5.86 * e + 0.711 * self._integral + 5.46 * slope
        self._integral += self._dt * e
        self._filtered += self._dt * slope
        return self._command(u)


class ZinageLqi(_OfZinage):
    """u = -(K (x_s, p, v, z) + K_i int e), all states measured, as published.

    Parameters
    ----------
    facts : of the case

    Raises KeyError in its first step where the winch shows no swash and pressure.
    """

    GAIN = np.array([814.229012, -1.02561303e-4, 1260.27957, 61238.9087])
    INTEGRAL_GAIN = -316227.766

    def __init__(self, facts: Facts) -> None:
        super().__init__(facts)
        self._integral = 0.0

    def step(self, measurement: Measurement) -> Command:
        """See `Controller.step`."""
        winch = measurement.winch
        seen = winch.instruments
        state = -np.array([seen["swash"], seen["pressure_pa"], winch.payout_rate, winch.payout])
        u = -float(self.GAIN @ state + self.INTEGRAL_GAIN * self._integral)
        self._integral += self._dt * self._error(measurement)
        return self._command(u)


class ZinageInversion:
    """The winch's equations solved for its input, with the future of the heave known: no entry, a reference.

    With the heave h to be followed by the payout: p from v' = -(eta A p + d v)/M, the swash from p', and the input from
    u = x + T_p x', at the middle of the sample time. Fourth derivatives of the heave are needed.

    Parameters
    ----------
    facts : of the case, with preview
    """

    needs_preview = True

    def __init__(self, facts: Facts) -> None:
        if facts.preview is None:
            raise ValueError("an inversion needs the preview")
        self._preview = facts.preview
        self._half = 0.5 * facts.sample_time
        self._drive = zinage_drive()

    def step(self, measurement: Measurement) -> Command:
        """See `Controller.step`."""
        p = self._drive
        _, v, a, j, s = self._preview(measurement.time + self._half)
        friction, force = p.friction.viscous, p.area * p.motor_efficiency
        stiffness = 2.0 * p.bulk_modulus / p.line_volume
        flow = p.pump_displacement * p.pump_speed
        pressure_rate = -(p.mass * j + friction * a) / force
        pressure_acceleration = -(p.mass * s + friction * j) / force
        swash = (p.area * v - pressure_rate / stiffness) / flow
        swash_rate = (p.area * a - pressure_acceleration / stiffness) / flow
        off = v - measurement.winch.payout_rate + 0.5 * (measurement.mru[-1].heave - measurement.winch.payout)
        return Command(p.full_speed * (swash + p.swash_time_constant * swash_rate) + 2.0 * off)


class Mas410Law:
    """v_set = heave rate + 16 (heave - payout): the outer loop of a published solution of MAS410.

    Parameters
    ----------
    facts : of the case
    """

    def __init__(self, facts: Facts) -> None:
        del facts
        self._heave = self._rate = 0.0

    def step(self, measurement: Measurement) -> Command:
        """See `Controller.step`."""
        if measurement.mru:
            self._heave, self._rate = measurement.mru[-1].heave, measurement.mru[-1].heave_rate
        return Command(self._rate + 16.0 * (self._heave - measurement.winch.payout))
