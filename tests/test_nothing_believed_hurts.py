"""What was learnt or assumed wrongly moves no tonnes: the drum stays within the last minute's heave and 0.3 m."""

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from winch_controller_node.beliefs.beliefs import Belief, Beliefs, EncoderScale, parameters_under
from winch_controller_node.design.design import design_controller

from tests.loops import TICK, Stepped, fault, loop_of

ROOM = 0.3
"""Travel beyond the largest heave of the boom tip in the minute before [m]."""

STOPS = ("fade_out", "stopping", "stopped", "emergency_stop", "standby")


class Run(Stepped):
    """A loop of a shipped scenario, up to a time at which it compensates; what happens after it is judged."""

    def __init__(self, scenario, seed, begin, settings=None):
        super().__init__(loop_of(scenario, settings, seed=seed))
        self.begin = begin
        self.go(begin)
        assert self.modes[-1] == "compensating"

    @property
    def travel(self):
        """Largest distance of the drum from where it was, over the heave of the boom tip in the minute before [m]."""
        drum, time = self.column("payout", self.begin - 60.0), self.column("time", self.begin - 60.0)
        return np.max(np.abs(drum[time >= self.begin] - np.mean(drum[time < self.begin])))

    @property
    def allowed(self):
        heave = self.column("boom_tip", self.begin - 60.0)
        return np.max(np.abs(heave - np.mean(heave))) + ROOM

    def inject(self, quantity, value):
        """Have the core take what an adviser says of a `quantity`."""
        controller, asked = self.loop.controller, self.loop.tick - 1
        beliefs = Beliefs(asked, 1000, MappingProxyType({quantity: Belief(quantity, value)}))
        if quantity == "encoder.scale":
            gate = controller.observer.encoder
            beliefs = replace(beliefs, encoder=EncoderScale(asked, value, gate.as_read, gate.as_read))
        under = parameters_under(beliefs, controller.nominal)
        if under != controller.nominal:
            cable = controller.design.cable
            share = under.cable_model.inertia_factor / controller.nominal.cable_model.inertia_factor
            design = design_controller(under, tick_period=TICK, cable=replace(cable, a=cable.a * share))
            beliefs = replace(beliefs, design=design)
        controller.take(beliefs)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scenario", "seed"),
    [
        ("b2_calm_300", 3),
        pytest.param("b3_deep_900", 2, marks=pytest.mark.long),
        pytest.param("b3_deep_900", 3, marks=pytest.mark.long),
    ],
)
def test_an_encoder_that_freezes_is_lost_and_not_identified(scenario, seed):
    """It was found to read 3.7e-16 times the payout, and 50 m of wire went out at 2 m/s, while it came to rest."""
    run = Run(scenario, seed, 120.0, fault("encoder", "freeze", 120.0)).go(160.0)
    assert run.travel < run.allowed
    assert {"DRUM_OR_ENCODER: still", "COMPENSATION_LOST"} <= set(run.codes(run.begin))
    assert "IDENTIFIED, ENCODER: scale" not in run.codes(run.begin)
    assert run.modes[-1] == "stopped"


CANNOT_BE = (("encoder.scale", 0.05), ("cable.inertia_factor", 5.0), ("winch.command_delay", 1.0), ("mru.delay", 1.0))
"""What an adviser says: quantity and value. It was taken at once and never named: 32 m of wire, 11 times the motion
without compensation.
"""
COULD_BE = (("encoder.scale", 0.6), ("encoder.scale", 1.7), ("winch.speed_gain", 0.5), ("mru.scale", 0.55))
"""What could be, and the readings contradict: it was held for ever."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("quantity", "value", "begin", "seconds"),
    [
        *((*lie, 60.0, 15.0) for lie in CANNOT_BE),
        *((*lie, 80.0, 20.0) for lie in COULD_BE[:2]),
        *(pytest.param(*lie, 80.0, 20.0, marks=pytest.mark.long) for lie in COULD_BE[2:]),
    ],
)
def test_an_adviser_that_is_wrong_is_named_within_seconds_and_the_nominal_stays(quantity, value, begin, seconds):
    run = Run("b2_calm_300", 1, begin)
    run.loop.adviser = None
    for until in begin + 1.0 + np.arange(seconds):
        run.inject(quantity, value)
        run.go(until)
    assert run.travel < run.allowed
    (alarm,) = [alarm for time, alarm in run.alarms if alarm.name == "ADVISER_WRONG: set aside" and time > begin]
    assert quantity in alarm.values["fault"]
    assert not run.loop.controller.beliefs.values
    assert run.modes[-1] == "compensating" or (quantity, value) in COULD_BE


OF_DRUM = {
    "encoder freeze 0": ("DRUM_OR_ENCODER: still", "SENSOR_LOST, ENCODER: at fault"),
    "encoder scale -1": ("DRUM_OR_ENCODER: reversed", "SENSOR_LOST, ENCODER: at fault"),
    "winch reverse 0": ("DRUM_OR_ENCODER: reversed", "DRIVE_AT_FAULT"),
}


@pytest.mark.slow
@pytest.mark.parametrize("what", OF_DRUM)
def test_a_drum_that_does_not_follow_is_drive_or_encoder_until_the_depth_sensor_separates_them(what):
    """Without the supervision of the drive, and without the envelope, which would stop the drum first.

    Every fault of the drive blamed the encoder.
    """
    part, kind, size = what.split()
    alone = {"virtual_winch.supervision_time": 0.0, "winch_controller.envelope.active": "false"}
    run = Run("b2_calm_300", 1, 80.0, {**fault(part, kind, 80.0, size=float(size)), **alone}).go(90.0)
    either, who = OF_DRUM[what]
    codes, naming = run.codes(run.begin), ("DRUM_OR", "SENSOR_LOST, ENCODER: at fault", "DRIVE_A")
    assert [code for code in codes if code.startswith(naming)] == [either, who]
    assert not {"SENSOR_LOST, ENCODER: excluded", "IDENTIFIED, ENCODER: scale"} & set(codes)


@pytest.mark.slow
@pytest.mark.parametrize(("device", "on", "off"), [("virtual_winch.encoder", 1.0, 1.0), ("wave_vessel.mru", 3.0, 6.0)])
def test_compensation_does_not_go_on_with_a_sensor_that_comes_and_goes(device, on, off):
    """It was resumed three times in 70 s, and twenty times in three minutes."""
    count = 14
    starts = [60.0 + place * (on + off) for place in range(count)]
    settings = {
        f"{device}.faults.kind": f"[{','.join(['freeze'] * count)}]",
        f"{device}.faults.start": starts,
        f"{device}.faults.duration": [on] * count,
        f"{device}.faults.magnitude": [0.0] * count,
    }
    run = Run("b2_calm_300", 1, 60.0, settings).go(60.0 + min(count * (on + off), 40.0))
    changes = [mode for mode, before in zip(run.modes, ["", *run.modes[:-1]], strict=True) if mode != before]
    assert changes.count("compensating") <= 3
    assert run.modes[-1] in STOPS


@pytest.mark.slow
@pytest.mark.parametrize(("quantity", "value"), [COULD_BE[0], COULD_BE[3]])
def test_what_is_assumed_makes_no_step_in_the_order(quantity, value):
    """None larger than 1.5 times the largest change of the minute before in a tick, and 0.3 m/s2 more."""
    run = Run("b2_calm_300", 1, 80.0)
    run.loop.adviser = None
    run.inject(quantity, value)
    run.go(81.5)
    assert run.loop.controller.beliefs.values, "it is set aside later, if at all"
    run.go(82.5)
    steps = np.abs(np.diff(run.orders))
    before, after = steps[round(20.0 / TICK) : round(80.0 / TICK)], steps[round(80.0 / TICK) :]
    assert np.max(after) <= 1.5 * np.max(before) + 0.3 * TICK + 1e-9
