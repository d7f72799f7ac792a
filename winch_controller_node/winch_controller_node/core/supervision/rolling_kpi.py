"""Figures of merit over a rolling window, from sensors and estimates alone, by the formulas of `heave_node.kpi`."""

from __future__ import annotations

import math

from heave_core.watch import KpiRing
from heave_node import kpi

from winch_controller_node.interface.readings import RollingKpi
from winch_controller_node.parameters.model import WinchModelParameters


class KpiWindow:
    """Ring of the last samples; what it holds is in C++ (`heave_core`, kpi.cpp).

    Parameters
    ----------
    window : [s]; tick_period : [s]
    """

    def __init__(self, window: float, *, tick_period: float) -> None:
        self._dt = tick_period
        self._winch: WinchModelParameters | None = None
        rows = max(2, round(window / tick_period))
        self._ring = KpiRing({"tick_period": tick_period, "rows": rows, "speed": math.inf, "acceleration": math.inf})

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
        if winch is not self._winch:
            self._winch = winch
            self._ring.take_limits(kpi.AT_LIMIT * winch.speed_limit, kpi.AT_LIMIT * winch.acceleration_limit)
        self._ring.add(unit, uncompensated, tip, payout, rate, 0.0, tension, 0.0)

    def figures(self) -> RollingKpi:
        """Return the figures over what the window holds; those of a heave that no sensor reports now are NaN."""
        held = self._ring.statistics()
        return RollingKpi(
            window=held.rows * self._dt,
            unit_sigma=held.unit,
            uncompensated_sigma=held.uncompensated,
            boom_tip_sigma=held.tip,
            unit_efficiency=kpi.efficiency(held.unit, held.uncompensated),
            outlet_efficiency=kpi.efficiency(held.outlet, held.tip),
            significant_residual=kpi.significant(held.unit),
            max_abs_heave=held.largest,
            winch_speed_max=held.speed,
            winch_acceleration_max=held.acceleration,
            power_peak=held.power,
            power_mean=held.mean_power,
            tension_min=held.least_tension,
            tension_max=held.largest_tension,
            time_at_limit=held.at_limit,
        )
