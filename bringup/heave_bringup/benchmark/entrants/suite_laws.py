"""The suite's own laws as entrants: they get what every entrant gets, and nothing else.

The controller is the component that the node runs, at its own 20 Hz; where a case is sampled faster it works at every
so many samples, with all readings of the newest one.
"""

from __future__ import annotations

from collections.abc import Callable

from heave_node.interface.sensors import DEPTH, LOAD_CELL, MruReading
from heave_node.parameters import build_parameters
from winch_controller_node.component import WinchController
from winch_controller_node.interface.readings import Measurements, ScalarReading, WinchReading
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_bringup.benchmark import interface
from heave_bringup.benchmark.interface import NO_WINCH_READING, Command, Facts, Measurement, Reading

TICK_PERIOD = 0.05
KNOWN_LIMITS = 15
"""Limits that are passed on: speed, acceleration, payout, power; those inside a published drive are no measurement."""


class SuiteController:
    """The controller of this suite under one of its laws.

    Parameters
    ----------
    facts : of the case; the belief holds the controller's parameters
    law : by its name in the registry of laws
    """

    def __init__(self, facts: Facts, law: str) -> None:
        values = {**facts.belief, "law": law}
        parameters = build_parameters(WinchControllerParameters, values, where=f"case {facts.case}")
        self._every = max(1, round(TICK_PERIOD / facts.sample_time))
        self._dt = facts.sample_time * self._every
        self._controller = WinchController(parameters, tick_period=self._dt)
        self._samples = 0
        self._taken = 0
        self._payout = 0.0
        self._command = Command(brake=True)

    def step(self, measurement: Measurement) -> Command:
        """See `Controller.step`."""
        due = self._samples % self._every == 0
        self._samples += 1
        if due:
            tick = round(measurement.time / self._dt)
            order = self._controller.step(tick, self._measurements(measurement)).order
            self._taken = order.sequence
            self._command = Command(order.payout_rate, order.payout, order.brake)
        return self._command

    def _measurements(self, given: Measurement) -> Measurements:
        return Measurements(
            mru=tuple(_mru(r) for r in given.mru),
            scalar={DEPTH.name: _scalars(given.depth), LOAD_CELL.name: _scalars(given.load_cell)},
            winch=None if given.winch is NO_WINCH_READING else self._winch(given.time, given.winch),
        )

    def _winch(self, time: float, winch: interface.WinchReading) -> WinchReading:
        rate = winch.payout_rate if self._every == 1 else (winch.payout - self._payout) / self._dt
        self._payout = winch.payout
        return WinchReading(
            time=time,
            encoder_payout=winch.payout,
            encoder_payout_rate=rate,
            brake=winch.brake,
            fault=winch.fault,
            command_sequence=winch.command if self._every == 1 else self._taken,
            limits_hit=winch.limits & KNOWN_LIMITS,
        )


def _mru(r: interface.MruReading) -> MruReading:
    return MruReading(
        time=r.time,
        heave=r.heave,
        heave_rate=r.heave_rate,
        roll=r.roll,
        pitch=r.pitch,
        status=r.status,
        sequence=r.sequence,
        heave_acceleration=r.heave_acceleration,
        heave_sigma=r.heave_sigma,
        heave_rate_sigma=r.heave_rate_sigma,
    )


def _scalars(readings: tuple[Reading, ...]) -> tuple[ScalarReading, ...]:
    return tuple(ScalarReading(r.time, r.value) for r in readings)


def suite_law(law: str) -> Callable[[Facts], SuiteController]:
    """Return the entrant of a law."""

    def make(facts: Facts) -> SuiteController:
        return SuiteController(facts, law)

    return make
