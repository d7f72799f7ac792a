"""A scenario of the suite as a problem: its sea, plant, winch, sensors, and the entrant in the controller's place."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
from heave_node.interface.sensors import DEPTH, LOAD_CELL
from heave_node.numerics.arrays import Array
from winch_controller_node.interface.readings import Measurements, Outputs, Report, WinchOrder

from heave_bringup.benchmark.interface import (
    NO_WINCH_READING,
    Controller,
    Measurement,
    MruReading,
    Reading,
    Target,
    WinchReading,
)
from heave_bringup.benchmark.outcome import Outcome
from heave_bringup.benchmark.target import TargetProgramme
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.run.loop_signals import run_signals
from heave_bringup.scenarios import Scenario


def _no_report() -> Report:
    """Refuse the report of a tick: an entrant gives commands only, and the loop itself reads no report."""
    raise RuntimeError("an entrant gives commands only: a report of the tick is made by the suite's controller alone")


class _ControllerStandIn:
    """Puts an entrant where the loop has its controller: converts measurements and commands, and numbers them."""

    def __init__(self, entrant: Controller, target: TargetProgramme, sample_time: float) -> None:
        self._entrant = entrant
        self._target = target
        self._dt = sample_time
        self._sent = 0

    def step(self, tick: int, delivered: Measurements) -> Outputs:
        """Do tick k as the suite's controller would."""
        time = tick * self._dt
        target = self._target.at(time)
        command = self._entrant.step(measurement_of(time, delivered, target))
        self._sent += 1
        order = WinchOrder(self._sent, command.payout, command.payout_rate, command.brake)
        return Outputs(order, "compensating", 1.0, target.payout, _no_report)


@dataclass
class ScenarioWorld:
    """A scenario, ready to run once.

    Attributes
    ----------
    scenario : checked, with seed and duration
    """

    scenario: Scenario
    _rows: Array = field(default_factory=lambda: np.empty(0))

    def run(self, controller: Controller) -> Outcome:
        """Run to the end under a controller."""
        parameters = loop_parameters(self.scenario)
        loop = ClosedLoop(parameters)
        target = TargetProgramme(self.scenario.parameters["winch_controller"], sample_time=parameters.tick_period)
        loop.controller = cast(Any, _ControllerStandIn(controller, target, parameters.tick_period))
        record = loop.run()
        time = record.column("time")
        has_bottom = parameters.plant.seabed.depth > 0.0
        return Outcome(
            time,
            run_signals(record, parameters),
            bottom_force=record.column("touchdown_force") if has_bottom else np.empty(0),
            unit_rate=record.column("unit_rate"),
            landing_end=_end_of_landing(self.scenario),
        )


def _end_of_landing(scenario: Scenario) -> float:
    """Return when the programme first lets a landed unit leave the bottom [s]."""
    programme = scenario.parameters["winch_controller"].programme
    rises = [
        time
        for time, payout, before in zip(
            programme.move_times[1:], programme.move_payouts[1:], programme.move_payouts, strict=False
        )
        if payout < before
    ]
    return min([*rises, *programme.mode_times], default=float("inf"))


def measurement_of(time: float, delivered: Measurements, target: Target) -> Measurement:
    """Return what an entrant gets at `time` [s]: the readings `delivered` by the loop, and the operator's `target`."""
    winch = delivered.winch
    reading = NO_WINCH_READING
    if winch is not None:
        reading = WinchReading(
            winch.encoder_payout,
            winch.encoder_payout_rate,
            winch.brake,
            winch.fault,
            winch.limits_hit,
            winch.command_sequence,
        )
    return Measurement(
        time=time,
        mru=tuple(
            MruReading(
                r.time,
                r.heave,
                r.heave_rate,
                r.heave_acceleration,
                r.roll,
                r.pitch,
                r.status,
                r.sequence,
                r.heave_sigma,
                r.heave_rate_sigma,
            )
            for r in delivered.mru
        ),
        depth=tuple(Reading(r.time, r.value) for r in delivered.of(DEPTH.name)),
        load_cell=tuple(Reading(r.time, r.value) for r in delivered.of(LOAD_CELL.name)),
        winch=reading,
        target=target,
    )
