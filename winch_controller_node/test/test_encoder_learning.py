"""A drum, or an encoder, that is reversed, in a closed loop of benchmark B3.

Its unit swings by 0.3 m (1 sigma) where it is let be; it compensates from 23 s on.
"""

import itertools

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_node.interface.alarm import Severity

TICK = 0.05
END = 125.0
MOVES = 0.01
"""A drum that is faster than this moves [m/s]."""

TURNED_OVER = {"kind": ["scale"], "start": [0.0], "duration": [0.0], "magnitude": [-1.0]}


def loop_of(who, duration=END):
    """Return a loop of a `duration` [s] in which `who` is reversed from the start."""
    settings = [f"all.duration={duration}", "all.seed=1"]
    if who == "encoder":
        settings += [f"virtual_winch.encoder.faults.{name}={value}" for name, value in TURNED_OVER.items()]
    loop = ClosedLoop(loop_parameters(load_scenario("b3_deep_900", settings=settings)))
    if who == "winch":
        step = loop.winch.step
        loop.winch.step = lambda tick, command, tension: step(
            tick, command._replace(payout_rate=-command.payout_rate), tension
        )
    return loop


def changes(modes):
    """Return modes without repetitions."""
    return [mode for mode, _ in itertools.groupby(modes)]


@pytest.mark.parametrize("who", ["winch", "encoder"])
def test_a_winch_that_goes_the_other_way_is_stopped_within_three_seconds_and_tried_again_only_on_request(who):
    """The envelope brakes a drum whose count runs against what was sent, where it sees that before it is at rest."""
    loop, reports = loop_of(who), []
    record = loop.run(lambda _, outputs: reports.append(outputs.report))
    time, unit, off = (record.column(name) for name in ("time", "unit", "uncompensated"))
    moving = time[np.abs(record.column("payout_rate")) > MOVES]
    assert 0.0 < moving[-1] - moving[0] < 3.0
    *before, end = changes(record.modes)
    assert before == ["standby", "compensating", "fade_out", "stopping"]
    assert end in ("standby", "stopped")
    for begin in np.arange(30.0, END - 60.0, 1.0):
        minute = (time >= begin) & (time < begin + 60.0)
        assert np.std(unit[minute]) < 1.05 * np.std(off[minute])
    # the finding is reported once; what stands beside it until somebody asks is that somebody has to
    assert [alarm.name for _, alarm in record.alarms].count("DRUM_OR_ENCODER: reversed") == 1
    stopped = max(k for k, report in enumerate(reports) if report.mode == "stopping")
    stands = [report.reason for report in reports[stopped + 1 :]]
    assert len(stands) > 60.0 / TICK
    assert all("request" in reason for reason in stands)
    # an operator who asks is not refused; it is no better, and stopped again, by the envelope where that comes first
    assert loop.controller.ask_for_mode("compensating") == "standby, on the way to compensating"
    found = [loop.step()[0] for _ in range(round(60.0 / TICK))]
    *before, rest = changes(outputs.mode for outputs in found)
    assert before in (["standby", "compensating", "fade_out", "stopping"], ["standby", "compensating", "stopping"])
    assert rest in ("standby", "stopped")
    assert [alarm.name for outputs in found for alarm in outputs.alarms].count("DRUM_OR_ENCODER: reversed") == 1


def test_a_winch_that_was_set_right_goes_on_once_an_operator_asks():
    loop = loop_of("winch", 60.0)
    assert "DRUM_OR_ENCODER: reversed" in {alarm.name for _, alarm in loop.run().alarms}
    del loop.winch.step  # what it is sent is what it does from now on
    loop.controller.set_mode("compensating")
    found = [loop.step() for _ in range(round(60.0 / TICK))]
    assert found[-1][0].mode == "compensating"
    blamed = {alarm.row.part for outputs, _ in found for alarm in outputs.alarms if alarm.severity > Severity.EVENT}
    assert not blamed & {"mru", "depth", "encoder", "cable"}


@pytest.mark.slow
@pytest.mark.parametrize(("used", "named"), [("mru, encoder, load_cell", True), ("mru, encoder", False)])
def test_a_load_cell_that_is_used_tells_a_frozen_encoder_from_a_drum_that_stands(used, named):
    """Nobody sees the load: by the tension alone it goes on as ordered."""
    fault = {"kind": ["freeze"], "start": [70.0], "duration": [0.0], "magnitude": [0.0]}
    settings = [f"virtual_winch.encoder.faults.{name}={value}" for name, value in fault.items()]
    settings += [f"winch_controller.sensors.use=[{used}]", "all.duration=80", "all.seed=5", "wave_vessel.ramp=20"]
    record = ClosedLoop(loop_parameters(load_scenario("b3_deep_900", settings=settings))).run()
    found = {alarm.name for time, alarm in record.alarms if time > 70.0}
    assert "DRUM_OR_ENCODER: still" in found
    assert ("SENSOR_LOST, ENCODER: at fault" in found) is named
    assert "DRIVE_AT_FAULT" not in found


def test_a_storm_blames_no_sensor_and_no_winch():
    """At its limits a winch does other than it was sent for a quarter of the time, and the cable is slack."""
    scenario = load_scenario("b5_storm", settings=["all.duration=200", "all.seed=1"])
    loop = ClosedLoop(loop_parameters(scenario))
    record = loop.run()
    assert record.modes[-1] == "compensating"
    assert owners(loop) <= {"sea"}
    assert loop.controller.observer.excluded == ""


def owners(loop):
    """Return what is assumed other than nominal."""
    return {name.partition(".")[0] for name in loop.controller.beliefs.values}
