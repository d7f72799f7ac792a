"""The signals of a loop in one process, for figures of merit: as a bag of the same run would give them."""

from __future__ import annotations

import math

import numpy as np
from heave_bags.analyse.events import take_modes
from heave_bags.analyse.reading.depth_programme import take_out_programme
from heave_bags.signals import RunSignals, Signal
from heave_node.loads.strength import strengths
from heave_node.parameters import flatten

from heave_bringup.closed_loop import LoopParameters, LoopRecord


def run_signals(record: LoopRecord, parameters: LoopParameters) -> RunSignals:
    """Return the signals of a run's `record`, made with `parameters`, that KPIs are computed from, as a bag of the same
    run would give them.
    """
    time, plant = record.column("time"), parameters.plant

    def signal(name: str) -> Signal:
        return Signal(time, record.column(name))

    signals = RunSignals(
        unit_heave=signal("unit"),
        uncompensated_heave=signal("uncompensated"),
        boom_tip_heave=signal("boom_tip"),
        payout=signal("payout"),
        payout_rate=signal("payout_rate"),
        payout_acceleration=signal("payout_acceleration"),
        tension=signal("top_tension"),
        largest_tension=signal("largest_top_tension"),
        uncompensated_tension=signal("uncompensated_tension"),
        uncompensated_largest_tension=signal("uncompensated_largest_tension"),
        unit_tension=signal("unit_tension"),
        slack=Signal(time, (record.column("slack_segments") > 0.0).astype(float)),
        limits_hit=signal("limits_hit"),
        static_tension=Signal(time[:1], record.column("top_tension")[:1]),
        unit_height=signal("unit"),
        touchdown=Signal(time, (record.column("touchdown_force") > 0.0).astype(float)),
        speed_limit=parameters.winch.speed_limit,
        acceleration_limit=parameters.winch.acceleration_limit,
        power_limit=parameters.winch.power_limit or math.inf,  # 0 means no limit
        strengths=strengths(flatten(plant), flatten(parameters.winch)),
    )
    weight = plant.cable.weight_in_fluid(plant.water_density, plant.gravity)
    take_modes(signals, time, np.asarray(record.modes))
    take_out_programme(signals, signal("depth_set_point"), weight)
    return signals
