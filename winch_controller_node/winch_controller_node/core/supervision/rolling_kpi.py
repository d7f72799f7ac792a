"""Figures of merit over a rolling window, from sensors and estimates alone, by the formulas of `heave_node.kpi`."""

from __future__ import annotations

import numpy as np
from heave_node import kpi
from heave_node.numerics.arrays import Array

from winch_controller_node.interface.readings import RollingKpi
from winch_controller_node.parameters.model import WinchModelParameters

COLUMNS = ("unit", "uncompensated", "tip", "payout", "rate", "acceleration", "tension", "at_limit")
HEAVES = np.array([name in ("unit", "uncompensated", "tip") for name in COLUMNS])
"""Columns that are unknown (NaN) where no sensor reports them."""


class KpiWindow:
    """Ring of the last samples.

    Parameters
    ----------
    window : [s]; tick_period : [s]
    """

    def __init__(self, window: float, *, tick_period: float) -> None:
        self._dt = tick_period
        self._ring: Array = np.full((max(2, round(window / tick_period)), len(COLUMNS)), np.nan)
        self._count = 0
        self._last_rate = 0.0

    def add(
        self,
        *,
        unit: float,
        uncompensated: float,
        tip: float,
        payout: float,
        rate: float,
        tension: float,
        winch: WinchModelParameters,
    ) -> None:
        """Take one tick in.

        Parameters
        ----------
        unit, uncompensated, tip : heave of the unit, of the uncompensated one, of the boom tip [m]; NaN: no sensor
            reports it
        payout, rate : of the winch, about its mean [m], [m/s]
        tension : at the top [N]; NaN: unknown
        winch : whose limits count in this tick
        """
        acceleration = (rate - self._last_rate) / self._dt
        self._last_rate = rate
        is_limited = (
            abs(rate) >= kpi.AT_LIMIT * winch.speed_limit
            or abs(acceleration) >= kpi.AT_LIMIT * winch.acceleration_limit
        )
        row = self._ring[self._count % len(self._ring)]
        row[:] = unit, uncompensated, tip, payout, rate, acceleration, tension, is_limited
        self._count += 1

    def figures(self) -> RollingKpi:
        """Return the figures over what the window holds; those of a heave that no sensor reports now are NaN."""
        rows = self._ring[: min(self._count, len(self._ring))]
        is_unknown = np.isnan(self._ring[(self._count - 1) % len(self._ring)]) & HEAVES
        rows = np.where(is_unknown, np.nan, rows[np.all(np.isfinite(rows) | is_unknown | ~HEAVES, axis=1)])
        unit, uncompensated, tip, payout, rate, acceleration, tension, limited = rows.T
        felt = np.isfinite(tension)
        power = kpi.winch_power(tension[felt], rate[felt])
        unit_sigma, uncompensated_sigma, tip_sigma = kpi.sigma(unit), kpi.sigma(uncompensated), kpi.sigma(tip)
        return RollingKpi(
            window=len(rows) * self._dt,
            unit_sigma=unit_sigma,
            uncompensated_sigma=uncompensated_sigma,
            boom_tip_sigma=tip_sigma,
            unit_efficiency=kpi.efficiency(unit_sigma, uncompensated_sigma),
            outlet_efficiency=kpi.efficiency(kpi.sigma(tip - payout), tip_sigma),
            significant_residual=kpi.significant(unit_sigma),
            max_abs_heave=kpi.max_abs(unit),
            winch_speed_max=float(np.max(np.abs(rate), initial=0.0)),
            winch_acceleration_max=float(np.max(np.abs(acceleration), initial=0.0)),
            power_peak=power.peak,
            power_mean=power.mean_abs,
            tension_min=float(np.min(tension[felt])) if np.any(felt) else np.nan,
            tension_max=float(np.max(tension[felt])) if np.any(felt) else np.nan,
            time_at_limit=float(np.mean(limited)) if len(rows) else 0.0,
        )
