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
        self._dt, rows = tick_period, max(2, round(window / tick_period))
        limits = {"speed": math.inf, "acceleration": math.inf}
        self._ring = KpiRing({"tick_period": tick_period, "rows": rows, **limits})
        self.records = self._ring.records  # of the core, by name

    def take_winch(self, winch: WinchModelParameters) -> None:
        """Count by the limits of another `winch` from now on."""
        self._ring.take_limits(kpi.AT_LIMIT * winch.speed_limit, kpi.AT_LIMIT * winch.acceleration_limit)

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
