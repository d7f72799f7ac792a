"""Whole loops in one process: a shipped scenario with settings, and what its record says of the promise."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from cable_sim_node.node_parameters import CableSimNodeParameters, LinearModelParameters
from cable_sim_node.parameters import UnitParameters
from cable_sim_node.winch.parameters import WinchParameters
from heave_bringup.closed_loop import ClosedLoop, LoopParameters, LoopRecord, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_node.interface.alarm import Alarm, alarms_in
from heave_node.kpi import window_ratios
from heave_node.parameters import build_parameters
from heave_studies.promise.run import blamed_by
from wave_vessel_node.parameters import WaveVesselParameters
from winch_controller_node.node_parameters import WinchControllerParameters

FAULTS = {
    "mru": "wave_vessel.mru",
    "encoder": "virtual_winch.encoder",
    "depth": "cable_sim.sensors.depth",
    "winch": "virtual_winch",
}
"""Group of parameters of what can be at fault."""

TICK = 0.05
"""Tick period of the shipped scenarios [s]."""

TROUBLE = 30.0
"""Time after compensation begins, after a fault and after its end, from which on the promise holds [s]."""


def fault(part: str, kind: str, start: float, lasting: float = 0.0, size: float = 0.0) -> dict[str, object]:
    """Return the settings of a fault of a part that begins at a `start` [s]; it ends after `lasting` [s], 0: never."""
    values = {"kind": kind, "start": start, "duration": lasting, "magnitude": size}
    return {f"{FAULTS[part]}.faults.{name}": f"[{value}]" for name, value in values.items()}


def settings_text(settings: Mapping[str, object]) -> list[str]:
    """Return settings as the option `--set` has them."""
    return [f"{name}={value}" for name, value in settings.items()]


def parameters_of(scenario: str, settings: Mapping[str, object] | None = None, **run: float) -> LoopParameters:
    """Return the parameters of a scenario under `settings`; `run` are those of all nodes: duration, seed, transient."""
    given = {**(settings or {}), **{f"all.{name}": value for name, value in run.items()}}
    return loop_parameters(load_scenario(scenario, settings=settings_text(given)))


def loop_of(scenario: str, settings: Mapping[str, object] | None = None, **run: float) -> ClosedLoop:
    """Return the loop; arguments as of `parameters_of`."""
    return ClosedLoop(parameters_of(scenario, settings, **run))


def quick_parameters(settings: Mapping[str, object], duration: float) -> LoopParameters:
    """Return those of a calm sea in which compensation begins soon, on a coarse cable; for a loop without adviser."""
    quick = {"winch_controller.modes.settling_time": 5, "wave_vessel.ramp": 5, "cable_sim.segments": 6}
    return parameters_of("b2_calm_300", {**quick, **settings}, transient=20.0, duration=duration)


INERTIA, DAMPING = 7.339769, 0.1906759
"""The 900 m system of thesis 6.2.6 as identified there."""


def two_state_parameters(
    height: float = 1.5,
    period: float = 10.0,
    *,
    duration: float = 90.0,
    seed: int = 1,
    sea: Mapping[str, object] | None = None,
    winch: WinchParameters | None = None,
    **belief: object,
) -> LoopParameters:
    """Return those of the thesis's 900 m system on the two-state plant, in the sea that is assumed, begun soon."""
    assumed = {
        "length": 900.0,
        "cable_model.inertia": INERTIA,
        "cable_model.damping": DAMPING,
        "sea.significant_wave_height": height,
        "sea.peak_period": period,
        "modes.settling_time": 10.0,
        "modes.fade_in_time": 5.0,
    } | belief
    waves = {"significant_wave_height": height, "peak_period": period, "ramp": 20.0} | dict(sea or {})
    linear = LinearModelParameters(INERTIA, DAMPING)
    return LoopParameters(
        sea=build_parameters(WaveVesselParameters, waves, where="test"),
        plant=CableSimNodeParameters(model="linear", linear=linear, length=900.0, unit=UnitParameters()),
        winch=winch or WinchParameters(),
        controller=build_parameters(WinchControllerParameters, assumed, where="test"),
        duration=duration,
        seed=seed,
    )


def heave_of(record: LoopRecord) -> np.ndarray:
    """Return the heave of the unit about where it is asked to be at each tick [m]."""
    return np.asarray(record.column("unit") + record.column("depth_set_point"))


def worst_minute(record: LoopRecord, begin: float) -> float:
    """Return the largest spread of the unit in a minute over that with the winch locked, from `begin` on [s]."""
    _, ratios = window_ratios(record.column("time"), heave_of(record), record.column("uncompensated"), begin)
    assert ratios.size, "no minute to judge"
    return float(np.max(ratios))


def left(record: LoopRecord, begin: float) -> float:
    """Return the standard deviation of the unit over that with the winch locked, from `begin` on [s]."""
    return record.unit_sigma(begin) / record.uncompensated_sigma(begin)


def changes(record: LoopRecord) -> list[tuple[str, float]]:
    """Return each mode that was taken, with the time at which [s]."""
    before = ["", *record.modes[:-1]]
    found = zip(record.modes, before, record.column("time"), strict=True)
    return [(mode, float(time)) for mode, was, time in found if mode != was]


def begin_of(record: LoopRecord, mode: str = "compensating") -> float:
    """Return when a mode is first taken [s]; infinite: never."""
    return next((time for taken, time in changes(record) if taken == mode), math.inf)


def blamed(record: LoopRecord) -> set[str]:
    """Return the sensors and the cable that alarms blame; "noise is high" blames nobody."""
    read = [one for _, alarm in record.alarms for one in alarms_in(str(alarm))]
    return {part for one in read if one.code != "WINCH_MODEL_UPDATED" for part in blamed_by(one, noise=False)}


class Stepped:
    """A loop that runs on as a test asks, and what it has left so far.

    Parameters
    ----------
    loop : that is run

    Attributes
    ----------
    orders : payout rate that the controller has ordered at each tick [m/s]
    """

    def __init__(self, loop: ClosedLoop) -> None:
        self.loop = loop
        self.rows: list[np.ndarray] = []
        self.modes: list[str] = []
        self.alarms: list[tuple[float, Alarm]] = []
        self.orders: list[float] = []

    @property
    def time(self) -> float:
        """Time of the next tick [s]."""
        return self.loop.tick * TICK

    def go(self, until: float) -> Stepped:
        """Run until a time [s]."""
        while self.time < until:
            outputs, row = self.loop.step()
            self.rows.append(row)
            self.modes.append(outputs.mode)
            self.orders.append(outputs.order.payout_rate)
            self.alarms += [(self.time, alarm) for alarm in outputs.alarms]
        return self

    def column(self, name: str, after: float = 0.0) -> np.ndarray:
        """Return a column of the record from a time on [s]."""
        return np.asarray(LoopRecord(np.array(self.rows)).column(name, after=after))

    def codes(self, after: float = 0.0) -> list[str]:
        """Return the names of the alarms after a time [s]: their codes, with the reason where there are several."""
        return [alarm.name for time, alarm in self.alarms if time > after]
