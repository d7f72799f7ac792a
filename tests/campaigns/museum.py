"""The museum of incidents: each runs as built and with this suite, in one process, and is judged.

`python -m tests.campaigns.museum` prints the table of docs/guide/validation/museum.md, in a minute of processor time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from cable_sim_node.alarms import fault_alarm
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_node.interface.alarm import Alarm, Severity
from heave_node.interface.codes import WinchFault
from heave_node.numerics.arrays import Array

from tests.campaigns.in_process import commit_line

FOLDER = Path(__file__).parents[1] / "museum"
"""Scenarios of the incidents."""
AS_BUILT = "_as_built"
TICK = 0.05
"""Tick period of the scenarios [s]."""
TOUCHED = 1e3
"""Force of the bottom on a unit that has touched it [N]."""


@dataclass(frozen=True)
class Incident:
    """One incident."""

    scenario: str  # name of its file in FOLDER; with `AS_BUILT` that of the incident as published
    begin: float  # when it begins [s]; NaN: when the unit touches the bottom
    names: tuple[str, ...]  # codes of the alarms that name its cause
    stays: bool = False  # the load is to stay on what carries it, whatever the winch does


INCIDENTS = (
    Incident("museum_brake_energised", 30.0, ("DRUM_NOT_HELD: count",)),
    Incident("museum_pressure_returns", 40.0, ("WINCH_DRIVE_FAULT",)),
    Incident("museum_rope_off_sheave", 40.0, ("SENSOR_DOUBTFUL, ENCODER: jump",)),
    Incident("museum_payout_zero", math.nan, ("PAYOUT_DEPTH_DISAGREE",)),
    Incident("museum_locked_and_creeping", 35.0, ("DRUM_OR_ENCODER: still",)),
    Incident("museum_slack_taken_up", 62.0, ("UNIT_NOT_SUSPENDED",)),
    Incident("museum_load_on_deck", 30.0, ("UNIT_NOT_SUSPENDED",), stays=True),
)


@dataclass(frozen=True)
class Judged:
    """What an incident has come to."""

    # farthest that the unit came from where it was asked to be, or rope paid out on a unit that stands [m]
    moved: float
    # seconds from the begin to the first alarm that names the cause, negative before it, and that alarm; NaN, None:
    # there is none
    named: tuple[float, Alarm | None]
    at_alarm: float  # how far the unit had come by the tick before that alarm [m]; NaN without one
    # alarms that were raised from the begin on, events apart, each code once, with the seconds to it
    others: dict[str, float]


def run(name: str) -> LoopRecord:
    """Return the record of the scenario of a name, with the alarm of the winch's own node among the controller's."""
    loop = ClosedLoop(loop_parameters(load_scenario(str(FOLDER / f"{name}.yaml"))))
    of_winch: list[tuple[float, Alarm]] = []

    def look(_: int, __: object) -> None:
        state = loop.winch.state
        if state.fault is not WinchFault.NONE and not of_winch:
            of_winch.append(
                (state.time, fault_alarm(state.fault, state.release, brake=state.brake, cause=loop.winch.supervised))
            )

    record = loop.run(look)
    record.alarms[:] = sorted(record.alarms + of_winch, key=lambda alarm: alarm[0])
    return record


def away(record: LoopRecord, *, stays: bool = False) -> Array:
    """Return how far the unit is from where it was asked to be, at each tick [m], positive up.

    Under compensation that is its set-point; as authority fades it is where the same unit is under a locked winch, and
    so it is for one that `stays` on what carries it.
    """
    unit, free = record.column("unit"), record.column("uncompensated")
    if stays:
        return unit - free
    follows = np.where(np.array(record.modes) == "constant_tension", 1.0, record.column("authority"))
    return unit + record.column("depth_set_point") - free[0] - (1.0 - follows) * (free - free[0])


@cache
def judge(incident: Incident, suffix: str = "") -> Judged:
    """Run an incident and judge it.

    Parameters
    ----------
    incident : of `INCIDENTS`
    suffix : `AS_BUILT`, or empty
    """
    record, begin, names = run(incident.scenario + suffix), incident.begin, incident.names
    time = record.column("time")
    if math.isnan(begin):
        begin = float(time[np.argmax(record.column("touchdown_force") > TOUCHED)])
    distance = away(record, stays=incident.stays)[time >= begin - 1e-9]
    distance = np.abs(distance - distance[0])
    alarms = [(at - begin, alarm) for at, alarm in record.alarms]
    named = next(((after, alarm) for after, alarm in alarms if alarm.name in names), (math.nan, None))
    others: dict[str, float] = {}
    for after, alarm in alarms:
        if after >= -1e-9 and alarm.severity is not Severity.EVENT and alarm.name not in names:
            others.setdefault(alarm.name, after)
    at_alarm = float(distance[: max(round(named[0] / TICK), 1)].max()) if named[1] else math.nan
    return Judged(float(distance.max()), named, at_alarm, others)


def row(incident: Incident, suffix: str) -> str:
    """Return an `incident` as a row of the table."""
    judged = judge(incident, suffix)
    after, alarm = judged.named
    told = f"{alarm.name} | {after:.2f} | {100.0 * judged.at_alarm:.0f}" if alarm else "- | - | -"
    others = ", ".join(f"{code} {at:.1f} s" for code, at in judged.others.items())
    return f"| {incident.scenario + suffix} | {100.0 * judged.moved:.0f} | {told} | {others} |"


def main() -> None:
    """Print the table."""
    rows = [row(incident, suffix) for incident in INCIDENTS for suffix in (AS_BUILT, "")]
    print(  # noqa: T201
        commit_line(),
        "| scenario | moved cm | alarm | s | cm by then | others |\n|---|---|---|---|---|---|",
        *rows,
        sep="\n",
    )


if __name__ == "__main__":
    main()
