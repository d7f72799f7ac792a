"""Acceptance tests of a winch by itself: set signals, figures with exact answers, and the step that fails."""

import json
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cable_sim_node.winch.parameters import WinchParameters
from heave_bags.signals import RunSignals, Signal
from heave_bringup.cli import main
from heave_devices.adapt.device import LiveDevice
from heave_devices.adapt.shipped import find_map
from heave_devices.bench import set_signal
from heave_devices.bench.limits import Limits
from heave_devices.bench.real_winch import RealPart
from heave_devices.bench.set_signal import Event, WinchTest
from heave_devices.bench.winch import VirtualPart, run_winch
from heave_node.criteria import Criterion
from heave_node.parameters import ParameterError
from heave_studies.accept import measured as figures
from heave_studies.accept.measured import Measured, Nominal, of_winch
from heave_studies.accept.procedure import amount, read_head, read_procedure
from heave_studies.accept.runs import scenario_of
from heave_studies.accept.study import Acceptance, Parts
from heave_studies.study.study_file import find_study
from sensor_msgs.msg import JointState

from tests.adapt_fakes import Node

NOMINAL = Nominal(2.0, 1.5, 0.35)
FAILS_OF_SLOW = {"speed_limit": {"Full speed"}, "acceleration_limit": {"Acceleration"}}
"""Steps that say so where a winch has 80 % of its nominal speed, or of its nominal acceleration."""


def following(lag, gain):
    """Return a payout that follows its rate order, each held for 0.05 s, after a lag [s] with a gain, exactly."""
    time = np.arange(0.0, 60.0, 0.05)

    def ordered(at):
        return np.sin(0.7 * at) + 0.5 * np.sin(1.1 * at + 1.0)

    moved = np.concatenate(([0.0], np.cumsum(gain * ordered(time[:-1])) * 0.05))
    payout = Signal(time, np.interp(time - lag, time, moved))
    # reported as a drive does: over the time since the sample before
    rate = Signal(time, np.diff(payout.value, prepend=0.0) / 0.05)
    return Measured(
        RunSignals(payout=payout, payout_rate=rate), 0.0, 60.0, Signal(time, ordered(time)), nominal=NOMINAL
    )


@pytest.mark.parametrize(("lag", "gain"), [(0.0, 1.0), (0.35, 0.8), (0.733, 1.1), (1.2, -1.0)])
def test_lag_and_gain_of_a_winch_are_those_it_has(lag, gain):
    found = figures.evaluate(following(lag, gain))
    assert found["following_lag_s"] == pytest.approx(lag, abs=0.002)
    assert found["lag_excess_s"] == pytest.approx(lag - 0.35, abs=0.002)
    assert found["following_gain"] == pytest.approx(gain, rel=0.005)
    assert found["following_error"] < 0.015, "the steps of the orders are 1.1 % of them"


def stopped(tick, event=10.0, end=15.0):
    """Return a drum at 1 m/s that stops at 2 m/s^2 from 10 s on, reported every tick [s], with an event [s]."""
    time = np.arange(0.0, 15.0, tick)
    rate = np.clip(1.0 - 2.0 * (time - 10.0), 0.0, 1.0)
    run = RunSignals(payout=Signal(time, np.cumsum(rate) * tick), payout_rate=Signal(time, rate))
    return Measured(run, 0.0, end, event=event)


def test_a_stop_takes_the_time_and_the_way_of_its_deceleration():
    # 0.475 s to 0.05 m/s, and v^2/2a less the rest
    found = figures.evaluate(stopped(0.001))
    assert found["stopping_time_s"] == pytest.approx(0.475, abs=0.002)
    assert found["stopping_distance_m"] == pytest.approx((1.0 - 0.05**2) / 4.0, abs=0.002)
    assert np.isnan(figures.evaluate(stopped(0.001, end=10.2))["stopping_time_s"])
    # reported every 0.1 s the drum is known to be at rest at 10.5 s, not before
    assert figures.evaluate(stopped(0.1))["stopping_time_s"] == pytest.approx(0.5)


@pytest.mark.parametrize("event", [10.48, 12.0])
def test_a_drum_that_rests_when_the_event_comes_shows_no_stop(event):
    measured = stopped(0.001, event)
    values = figures.evaluate(measured)
    for wanted in (Criterion("stopping_time_s", "<=", 1.0), Criterion("stopping_distance_m", "<=", 1.0)):
        one = figures.judged(wanted, values, measured)
        assert not one.is_met
        assert "the drum was not moving" in str(one)


def test_rate_gap_and_noise_of_a_sensor_are_those_it_has():
    draw, time = np.random.default_rng(1), np.arange(0.0, 100.0, 0.1)
    time = time[(time < 50.0) | (time > 50.65)]
    depth = 300.0 + 0.5 * np.sin(0.6 * time) + draw.normal(0.0, 0.02, time.size)
    found = figures.evaluate(Measured(RunSignals(), 0.0, 100.0, readings={"depth": Signal(time, depth)}))
    assert found["depth_rate_hz"] == pytest.approx(10.0, rel=0.01)
    assert found["depth_gap_max_s"] == pytest.approx(0.8, abs=0.11)
    assert found["depth_noise_m"] == pytest.approx(0.02, rel=0.1)


def test_signs_and_scales_of_depth_by_payout_and_heave_are_told_apart():
    time = np.arange(0.0, 120.0, 0.1)
    heave, payout = np.sin(0.6 * time), np.clip(0.1 * (time - 60.0), 0.0, 3.0)
    depth = 20.0 - 0.9 * heave + 1.05 * payout
    readings = {name: Signal(time, of) for name, of in (("mru", heave), ("depth", depth), ("encoder", payout))}
    found = figures.evaluate(Measured(RunSignals(), 0.0, 120.0, readings=readings))
    assert found["depth_per_heave"] == pytest.approx(0.9, abs=1e-6)
    assert found["depth_per_payout"] == pytest.approx(1.05, abs=1e-6)


def test_an_irregular_sea_has_the_height_that_is_asked_for():
    # over twice its duration, after which it repeats itself, its variance is exact; 0.4 to 4 peak frequencies hold all
    # but 0.5 % of it, and the fade at the start takes a little
    time = np.arange(0.0, 600.0, 0.1)
    payout = np.cumsum(set_signal.sea(2.0, 8.0, 300.0).rate(time)) * 0.1
    assert 4.0 * np.std(payout) == pytest.approx(2.0, rel=0.02)


def test_a_sweep_goes_from_its_first_period_to_its_last():
    signal = set_signal.sweep(0.5, 20.0, 4.0, 240.0)
    time = np.arange(0.0, 240.0, 0.001)
    ups = time[1:][np.diff(np.sign(signal.rate(time))) > 0]
    assert np.diff(ups)[0] == pytest.approx(19.0, abs=2.0)
    assert np.diff(ups)[-1] == pytest.approx(4.0, abs=0.2)


@pytest.fixture(scope="module")
def steps():
    head = read_head(find_study("winch_factory_test"))
    return read_procedure(head, Limits(NOMINAL.speed, NOMINAL.acceleration)).steps


def failing(steps, parameters):
    found = set()
    for step in steps:
        trace = run_winch(VirtualPart(parameters, step.test.load), step.test, step.event, step.name, lambda *_: None)
        values = figures.evaluate(of_winch(trace, step.test, NOMINAL), step.alarms)
        found |= {step.name for one in step.wanted if not figures.judged(one, values).is_met}
    return found


def test_the_nominal_winch_passes_its_factory_test(steps):
    assert failing(steps, WinchParameters()) == set()


@pytest.mark.parametrize("more", [0.0, 0.1])
def test_the_lag_beyond_nominal_is_what_a_winch_has_more_of_it(more, steps):
    sweep = next(step for step in steps if step.name == "Sine sweep")
    part = VirtualPart(WinchParameters(command_delay=0.2 + more), 30e3)
    values = figures.evaluate(of_winch(run_winch(part, sweep.test, None, "", lambda *_: None), sweep.test, NOMINAL))
    # at the shortest period, 4 s, a time constant of 0.15 s is a lag of 0.147 s
    assert values["lag_excess_s"] == pytest.approx(more, abs=0.003)


@pytest.mark.parametrize("limit", FAILS_OF_SLOW)
def test_a_winch_that_is_a_fifth_too_slow_fails_at_the_step_that_says_so(limit, steps):
    slow = replace(WinchParameters(), **{limit: 0.8 * getattr(WinchParameters(), limit)}, stop_deceleration=1.0)
    assert failing(steps, slow) == FAILS_OF_SLOW[limit]


def test_a_brake_that_slips_fails_where_the_brake_holds_the_load(steps):
    held = steps[0]
    part = VirtualPart(WinchParameters(), 30e3)
    trace = run_winch(part, held.test, Event("winch", "brake_slip", 1.0, magnitude=0.01), held.name, lambda *_: None)
    values = figures.evaluate(of_winch(trace, held.test, NOMINAL))
    assert values["payout_drift_m"] == pytest.approx(0.05, rel=0.1), "5 s at 1 cm/s are watched after an event"


def test_a_winch_that_falls_silent_meets_nothing_and_the_time_is_said(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    node = Node()
    device = LiveDevice(find_map("ros2_control_velocity"), node)

    def spin(duration):
        now[0] += duration
        if now[0] < 105.0:
            message = JointState(name=["drum"], position=[690.0], velocity=[0.0])
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(round(1e9 * now[0]), 10**9)
            node.callbacks["/joint_states"](message)

    test = WinchTest(set_signal.hold(20.0))
    trace = run_winch(RealPart(device, spin, lambda _: None), test, None, "held", lambda *_: None)
    measured = of_winch(trace, test, NOMINAL)
    one = figures.judged(Criterion("payout_drift_m", "<=", 0.01), figures.evaluate(measured), measured)
    assert not one.is_met
    # of the 5 s up to then 1.2 s went to its first report and to its brake
    assert "the winch fell silent at 3.8 s" in str(one)
    assert trace.rows[-1, 0] < 3.9, "what it repeats is no report"


def test_the_command_judges_writes_its_report_and_judges_its_own_records_again(tmp_path, capsys):
    json_file, folder = tmp_path / "result.json", tmp_path / "out"
    arguments = ["--ask", "step=[Full speed, Ramp]"]
    assert main(["study", "winch_factory_test", *arguments, "--output", str(folder), "--json", str(json_file)]) == 0
    result = json.loads(json_file.read_text())
    assert [step["state"] for step in result["steps"]] == ["passed", "passed"]
    page = (folder / "page.html").read_text(encoding="utf-8")
    for words in ("Signatures", "SHA-256", result["steps"][0]["sha256"], "surveyor", "passed: 2"):
        assert words in page.replace("<strong>", "").replace("</strong>", "")
    capsys.readouterr()


def test_a_slow_winch_gives_exit_status_3_and_names_the_step(tmp_path, capsys):
    slow = ["--set", "virtual_winch.speed_limit=1.6", "--output", str(tmp_path / "out")]
    assert main(["study", "winch_factory_test", "--ask", "step=Full speed", *slow]) == 3
    assert "Full speed: Speed reached" in capsys.readouterr().err


HEAD = "title: t\nscenario: b2_calm_300\nsteps:\n"


@pytest.mark.parametrize(
    ("step", "words"),
    [
        ("- {name: a, winch: {signal: hold, duration: 5 s}}", "step 1 (a): wanted is missing"),
        ("- {name: a, winch: {signal: hold, duration: 5 m}, wanted: {overshoot: '< 1 %'}}", "duration = '5 m'"),
        ("- {name: a, winch: {signal: step}, wanted: {overshoot: '< 1 %'}}", "must be one of steps, ramp"),
        ("- {name: a, winch: {signal: hold, duration: 5}, wanted: {overshot: '< 1 %'}}", "did you mean overshoot"),
        ("- {name: a, winch: {signal: hold, duration: 5}, wanted: {overshoot: '< 1 s'}}", "not a figure"),
        ("- {name: a, run: {duration: 5}, winch: {}, wanted: {snaps: '< 1'}}", "a winch or a run: give one"),
        ("- {name: a, run: {}, event: {device: mru, fault: gone, at: 1}, wanted: {snaps: '< 1'}}", "fault = 'gone'"),
        ("- {name: a, run: {}, alarms: [MRU_GONE], wanted: {snaps: '< 1'}}", "MRU_GONE is no code of an alarm"),
        ("- {name: a, run: {set: {winch_controller.low: mpc}}, wanted: {snaps: '< 1'}}", "there is no parameter low"),
        (
            "- {name: a, winch: {signal: sine, amplitude: 0.75, period: 8, cycles: 2}, "
            "event: {fault: emergency_stop, at: 160 s}, wanted: {stopping_time_s: '<= 1 s'}}",
            "step 1 (a): event: at = 160 s: must be within the step, which lasts 16 s",
        ),
        (
            "- {name: a, run: {duration: 50}, event: {fault: emergency_stop, at: 50}, wanted: {snaps: '< 1'}}",
            "a: event: at = 50 s",
        ),
        ("- {name: a, run: {}, wanted: {overshoot: '>= 95'}}", "overshoot = '>= 95': is 9500 %; write a bound above 1"),
        ("- {name: a, runs: {}, wanted: {snaps: '< 1'}}", "unknown key runs"),
        ("- {name: a, wanted: {snaps: '< 1'}}", "a winch or a run: give one"),
    ],
)
def test_what_is_wrong_with_a_procedure_is_one_line_before_anything_runs(step, words, tmp_path, capsys):
    path = tmp_path / "own.yaml"
    path.write_text(HEAD + step)
    assert main(["study", str(path), "--output", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("winch", "words"),
    [
        ("{signal: steps, speeds: [500 %, 0], hold: 3 s}", "needs 10 m/s, beyond the winch's 2 m/s"),
        ("{signal: ramp, speed: -900 %, acceleration: 50 %}", "needs 18 m/s"),
        ("{signal: ramp, speed: 50 %, acceleration: 200 %}", "3 m/s^2 is beyond the winch's 1.5 m/s^2"),
        ("{signal: sine, amplitude: 50 m, period: 8 s}", "m/s, beyond the winch's 2 m/s"),
        (
            "{signal: steps, speeds: [50 %], hold: 60 s}",
            "needs a payout of 0.1 to 60 m, beyond the winch's -50 to 50 m",
        ),
        ("{signal: hold, duration: 3 s, load: 30 MN}", "load = 30000 kN is beyond the tension at which the rope parts"),
        ("{signal: hold, duration: 3 s, load: -30 kN}", "must not be below 0"),
    ],
)
def test_what_the_nominal_winch_cannot_do_is_refused(winch, words, tmp_path, capsys):
    path = tmp_path / "own.yaml"
    path.write_text(HEAD + f"- {{name: a, winch: {winch}, wanted: {{overshoot: '< 1 %'}}}}")
    assert main(["study", str(path), "--check"]) == 2
    assert words in capsys.readouterr().err


def test_the_list_of_steps_shows_the_load(capsys):
    assert main(["study", "winch_factory_test", "--check"]) == 0
    assert "held by the brake for 10 s, load 30 kN" in capsys.readouterr().out


def test_amounts_have_units_and_percent_is_of_the_nominal_limit():
    limits = Limits(2.0, 1.5)
    assert amount("50 %", "speed", "", limits) == 1.0
    assert amount("30 kN", "force", "") == 30e3
    with pytest.raises(ParameterError, match="with or without a unit"):
        amount("50 %", "length", "", limits)


@pytest.mark.parametrize("name", ["winch_factory_test", "sensor_check", "harbour_test", "sea_trial"])
def test_each_shipped_procedure_is_right(name):
    kind = Acceptance(read_head(find_study(name)), Parts(), (), "", (), Path())
    assert kind.procedure.signatures
    assert all(step.what and step.wanted for step in kind.procedure.steps)


@pytest.mark.parametrize(("external", "faults"), [((), ("gap",)), (("mru=own",), ()), (("winch/load_cell",), ("gap",))])
def test_a_fault_is_simulated_unless_the_sensor_that_has_it_is_real(external, faults):
    procedure = read_procedure(read_head(find_study("sea_trial")), Limits(2.0, 1.5))
    step = next(step for step in procedure.steps if step.event and step.event.device == "mru")
    scenario = scenario_of(procedure, step.test, step.event, external)
    assert scenario.parameters["wave_vessel"].mru.faults.kind == faults
    assert scenario.run.external == tuple(text.partition("=")[0] for text in external)
