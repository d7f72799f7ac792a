"""Landing: touchdown, detected from the trends of depth, tension and mean payout; lift-off."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_core.watch_table import Landed
from heave_node.interface.alarm import Severity
from hypothesis import given, settings
from hypothesis import strategies as st
from winch_controller_node.core.supervision import landing as production
from winch_controller_node.core.supervision.landing import EVENTS, HangingLoad, LandingEvent
from winch_controller_node.core.supervision.modes import Mode, ModeOutput
from winch_controller_node.parameters.laws import TensionLawParameters

from tests.core_parts import add_depth, judge_landing, observe_landing, shows_hanging
from tests.gates import MeanTension
from tests.supervised import Supervised

DT = 0.05
DEPTH_NOISE = 0.02
"""Depth sensor of the benchmarks: 2 cm, 10 Hz, 0.1 s late."""

TENSION_NOISE = 0.005
"""Load cell of the benchmarks, of the tension."""

COMPENSATING = ModeOutput(Mode.COMPENSATING, "", 1.0, brake=False)
HOLDING = ModeOutput(Mode.CONSTANT_TENSION, "", 0.0, brake=False)


class Landing(production.Landing):
    """The landing detector, a tick at a time."""

    def observe(self, time, now, mean_payout, hanging):
        for stamp, depth in now.depths:
            add_depth(self.core, stamp, depth)
        is_weighed = "load_cell" not in now.lost
        observe_landing(self.core, time, now.tension, is_weighed, mean_payout, *hanging, now.depth_innovation)

    def update(self, now, mode):
        compensates = mode.mode is Mode.COMPENSATING and mode.authority > production.LEAST_AUTHORITY
        judge_landing(self.core, now.filtered_tension, now.sees_landing, bool(now.depths), compensates)
        return None if self.event is Landed.NOT else EVENTS[self.event]


def sensed(*, tension, depths=(), innovation=math.nan, has_depth=True, filtered=None, lost=()):
    return SimpleNamespace(
        tension=tension,
        filtered_tension=tension if filtered is None else filtered,
        depths=tuple(depths),
        depth_innovation=innovation,
        sees_landing=has_depth,
        lost=dict.fromkeys(lost, "frozen"),
    )


class Lowering:
    """A unit of 50 kN that is lowered on a cable, as its sensors see it; it touches the bottom at a time."""

    def __init__(self, *, stiffness, speed, contact, seed=1, swing=(0.0, 1.0), weight=50e3):
        self.load = HangingLoad(static_tension=1.2 * weight, weight=weight, stiffness=stiffness)
        self.landing = Landing(TensionLawParameters(), self.load)
        self._speed, self._contact, self._swing = speed, contact, swing
        self._random = np.random.default_rng(seed)
        self._tick = 0

    def depth(self, time):
        amplitude, omega = self._swing
        return min(self._speed * time, self._speed * self._contact) - amplitude * math.cos(omega * time)

    def hanging(self, time):
        """What a unit would do that had not landed."""
        amplitude, omega = self._swing
        swing = -amplitude * math.cos(omega * time)
        return (self._speed * time + swing, swing)

    def tension(self, time):
        """Relieved by what the winch lowers after the contact, and by the inertia of a unit that swings."""
        amplitude, omega = self._swing
        slack = self.load.stiffness * self._speed * max(time - self._contact, 0.0)
        inertia = self.load.weight / 9.81 * 1.8 * amplitude * omega**2 * math.cos(omega * time)
        carried = max(self.load.weight - slack, 0.0) - inertia
        return self.load.static_tension - self.load.weight + max(carried, 0.0)

    def run(self, duration, mode=COMPENSATING, *, has_depth=True, innovation=5.0, lost=()):
        """Return the time of the touchdown; None: there was none."""
        noise = self._random.standard_normal
        while self._tick * DT < duration:
            self._tick += 1
            time = self._tick * DT
            stamp = time - 0.1
            has_reading = self._tick % 2 == 0 and stamp > 0.0
            depths = [(stamp, self.depth(stamp) + DEPTH_NOISE * noise())] if has_reading else []
            tension = self.tension(time) * (1.0 + TENSION_NOISE * noise())
            now = sensed(tension=tension, depths=depths, innovation=innovation, has_depth=has_depth, lost=lost)
            self.landing.observe(time, now, self._speed * time, self.hanging(time))
            if self.landing.update(now, mode) is LandingEvent.TOUCHDOWN:
                return time
        return None


@settings(max_examples=30, deadline=None)
@given(
    stiffness=st.floats(math.log(5e3), math.log(5e6)).map(math.exp),
    speed=st.floats(0.05, 0.5),
    seed=st.integers(0, 1000),
)
def test_a_landing_is_known_before_the_winch_has_lowered_by_half_a_metre_on_soft_and_stiff_cables(
    stiffness, speed, seed
):
    contact = 12.0
    touchdown = Lowering(stiffness=stiffness, speed=speed, contact=contact, seed=seed).run(contact + 10.0)
    assert touchdown is not None
    assert contact < touchdown
    assert (touchdown - contact) * speed < 0.5


@settings(max_examples=15, deadline=None)
@given(speed=st.floats(0.05, 1.0), seed=st.integers(0, 1000), stiffness=st.sampled_from([5e3, 50e3, 5e6]))
def test_a_unit_that_is_lowered_through_the_water_never_lands(speed, seed, stiffness):
    assert Lowering(stiffness=stiffness, speed=speed, contact=math.inf, seed=seed).run(30.0) is None


@pytest.mark.parametrize("speed", [0.1, 0.3, 0.5])
@pytest.mark.parametrize("amplitude", [0.5, 1.0, 3.0])
def test_a_unit_that_swings_never_lands(speed, amplitude):
    """At the top of its swing the cable is least loaded and the unit stands for a moment, but nothing stays so."""
    for seed in range(3):
        swinging = Lowering(stiffness=27e3, speed=speed, contact=math.inf, seed=seed, swing=(amplitude, 0.4))
        assert swinging.run(60.0) is None


@pytest.mark.parametrize(
    "mode",
    [HOLDING, ModeOutput(Mode.COMPENSATING, "", 0.4, brake=False)],
    ids=["not compensating", "little authority"],
)
def test_only_a_unit_that_is_compensated_lands(mode):
    assert Lowering(stiffness=27e3, speed=0.2, contact=20.0).run(30.0, mode) is None


def test_a_landing_is_suspected_before_it_is_known_and_a_suspicion_does_not_last():
    lowering = Lowering(stiffness=5e3, speed=0.05, contact=20.0)
    lowering.run(20.0)
    state = lowering.landing.core.state[0]
    assert not state["may_stand"]
    suspected = [lowering.run(20.0 + DT * k) is None and state["may_stand"] for k in range(1, 100)]
    assert any(suspected)
    assert not state["may_stand"]


def test_without_a_depth_sensor_the_tension_alone_tells():
    """The cable is slack after 2.5 s; the mean over 10 s is then (11.25 - t)/10 of 50 kN: 0.6 of it at 5.25 s."""
    lowering = Lowering(stiffness=100e3, speed=0.2, contact=20.0)
    assert lowering.run(40.0, has_depth=False) == pytest.approx(25.25, abs=0.2)


@pytest.mark.parametrize(("amplitude", "omega"), [(3.0, 0.7), (4.0, 1.2), (15.0, 0.63)])
def test_without_a_depth_sensor_a_unit_never_lands_whose_cable_goes_slack_in_each_wave(amplitude, omega):
    """Relieved of up to 1.1 of the weight at the lowest point of each wave."""
    for seed in range(3):
        hanging = Lowering(stiffness=27e3, speed=0.2, contact=math.inf, seed=seed, swing=(amplitude, omega))
        assert hanging.run(90.0, has_depth=False) is None


def test_without_the_load_cell_the_depth_sensor_alone_tells_and_its_readings_count_no_more_until_it_has():
    """The mean of the unit's speed over 10 s is 0.4 of the winch's 6 s after contact: it is a line through a corner."""
    lowering = Lowering(stiffness=100e3, speed=0.2, contact=20.0)
    assert lowering.run(20.0, innovation=0.0, lost=("load_cell",)) is None
    assert shows_hanging(lowering.landing)
    assert lowering.run(23.0, lost=("load_cell",)) is None
    assert not shows_hanging(lowering.landing)
    assert lowering.run(40.0, lost=("load_cell",)) == pytest.approx(26.0, abs=1.0)


@pytest.mark.parametrize("speed", [0.1, 0.3, 0.5])
@pytest.mark.parametrize("amplitude", [0.0, 0.5, 3.0])
def test_without_the_load_cell_a_unit_that_swings_never_lands(speed, amplitude):
    for seed in range(3):
        swinging = Lowering(stiffness=27e3, speed=speed, contact=math.inf, seed=seed, swing=(amplitude, 0.8))
        assert swinging.run(60.0, lost=("load_cell",)) is None


LANDS_EARLY = (
    "cable_sim.seabed.depth=575.0",
    "winch_controller.programme.move_times=[40.0]",
    "winch_controller.programme.move_payouts=[14.0]",
    "winch_controller.programme.move_speeds=[0.12]",
    "winch_controller.programme.mode_times=[]",
    "winch_controller.programme.modes=[]",
    "wave_vessel.ramp=20.0",
)
"""Benchmark b7, over before a sea of its own has come up."""


@pytest.mark.slow
def test_a_load_that_lands_without_a_load_cell_is_told_of_and_is_compensated_until_it_is_lifted_again():
    """It stood on a rope that went slack, and the depth sensor was blamed, for as long as the winch lowered."""
    fitted = ["cable_sim.sensors.load_cell.fitted=false", "winch_controller.sensors.use=[mru,encoder,depth]"]
    loop = ClosedLoop(loop_parameters(load_scenario("b7_landing", settings=[*LANDS_EARLY, *fitted])))
    found, rows = {}, []
    for tick in range(round(180.0 / DT)):
        if tick == round(140.0 / DT):
            loop.controller.move_to_payout(loop.controller.mean.point.payout - 6.0, 0.2)
        outputs, row = loop.step()
        rows.append(row)
        found |= {alarm.name: tick * DT for alarm in outputs.alarms if alarm.severity is not Severity.LOW}
    record = LoopRecord(np.array(rows))
    time, force = record.column("time"), record.column("touchdown_force")
    contact = time[np.argmax(force > 0.0)]
    assert contact < found["TOUCHDOWN: by depth alone"] < contact + 13.0
    stands = (time > found["TOUCHDOWN: by depth alone"]) & (time < 140.0)
    assert np.min(force[stands]) > 0.0
    assert np.max(record.column("slack_segments")[stands]) == 0.0
    assert 140.0 < found["UNIT_SUSPENDED: by depth alone"] < 180.0
    lost = (
        "IDENTIFIED, DEPTH: scale",
        "WORSE_THAN_OFF: swing",
        "WORSE_THAN_OFF: estimate",
        "MOVE_LOST",
        "COMPENSATION_LOST",
    )
    assert not set(lost) & set(found)
    assert outputs.report.mode == "compensating"


def test_what_a_lost_load_cell_has_read_last_is_no_sign_of_a_landing():
    """It froze at the lowest tension of a wave, and is good again after 20 s."""
    load = HangingLoad(static_tension=60e3, weight=50e3, stiffness=27e3)
    landing = Landing(TensionLawParameters(), load)
    for tick in range(1, 1200):
        time = tick * DT
        is_lost = 20.0 < time < 40.0
        tension = 15e3 if is_lost else 60e3 + 45e3 * math.cos(2.0 * math.pi * time / 10.0)
        # the gate needs some readings to find it frozen
        lost = ("load_cell",) if 21.0 < time < 40.0 else ()
        now = sensed(tension=tension, has_depth=False, lost=lost)
        landing.observe(time, now, 0.2 * time, (0.2 * time, 0.0))
        assert landing.update(now, COMPENSATING) is None


FROZEN = tuple(
    f"cable_sim.sensors.depth.faults.{fault}" for fault in ("kind=[freeze]", "duration=[0.0]", "magnitude=[0.0]")
)
"""A depth sensor that freezes for good."""


def test_a_unit_lands_once_and_hangs_again_only_when_it_is_lifted():
    lowering = Lowering(stiffness=27e3, speed=0.2, contact=20.0)
    lowering.run(30.0)
    landing, load = lowering.landing, lowering.load
    assert landing.unit_stands
    hanging = sensed(tension=load.static_tension + 0.1 * load.weight)
    standing = sensed(tension=load.static_tension - 0.1 * load.weight)
    assert landing.update(hanging, HOLDING) is None
    landing.begin_lift_off()
    assert landing.update(standing, HOLDING) is None
    assert landing.update(hanging, HOLDING) is LandingEvent.LIFTED_OFF
    assert not landing.unit_stands
    assert landing.update(hanging, HOLDING) is None


def test_a_unit_that_is_where_a_hanging_one_is_expected_has_not_landed():
    assert Lowering(stiffness=27e3, speed=0.2, contact=20.0).run(30.0, innovation=0.5) is None


def test_a_winch_that_begins_to_lower_relieves_the_cable_by_the_inertia_of_the_unit_and_that_is_no_landing():
    """It stays behind a mean payout that speeds up at a = 0.05 m/s^2 by m a over the stiffness, m of 100 t."""
    load = HangingLoad(static_tension=600e3, weight=490e3, stiffness=270e3)
    landing = Landing(TensionLawParameters(), load)
    for tick in range(1, 200):
        time = tick * DT
        payout = 0.5 * 0.05 * max(time - 3.0, 0.0) ** 2
        depth = max(payout - 100e3 * 0.05 / 270e3, 0.0)
        depths = [(time - 0.1, depth)] if tick % 2 == 0 else []
        now = sensed(tension=load.static_tension - load.stiffness * (payout - depth), depths=depths, innovation=5.0)
        landing.observe(time, now, payout, (depth, payout - depth))
        assert landing.update(now, COMPENSATING) is None


@pytest.mark.parametrize("faults", [(), (*FROZEN, "cable_sim.sensors.depth.faults.start=[80.0]")], ids=["", "frozen"])
@pytest.mark.parametrize(("law", "height", "seed"), [("mpc", 3.0, 1), ("lqg", 4.0, 2)])
def test_an_operator_who_lifts_and_lowers_at_full_speed_in_a_high_sea_has_not_landed(law, height, seed, faults):
    """A unit that stayed behind the drum, or swung, was taken to stand: constant tension let it drop by metres."""
    sea = [f"system.sea.significant_wave_height={height}", f"all.seed={seed}"]
    settings = [f"winch_controller.law={law}", *sea, *faults]
    loop = ClosedLoop(loop_parameters(load_scenario("b3_deep_900", settings=[*settings, "all.duration=230"])))

    def operate(tick, outputs):
        time = tick * DT
        if outputs.mode == "compensating" and time > 90.0 and time % 40.0 < 20.0:
            loop.controller.operate(-3.0 if time % 80.0 < 40.0 else 3.0)

    record = loop.run(operate)
    assert np.max(record.column("touchdown_force")) == 0.0
    assert np.ptp(record.column("depth_set_point")) > 10.0
    assert set(record.modes) == {"standby", "compensating"}


class Braked(Supervised):
    """A braked winch over a unit of 50 kN on a cable of 10 N/m."""

    def __init__(self, *, more=0.0, swing_time=8.0):
        super().__init__(mode=Mode.STANDBY)
        self.landing, self._more, self._mean = self.supervisor.landing, more, MeanTension(tick_period=DT)
        self.landing.take_load(HangingLoad(60e3, 50e3, 1e6, swing_time=swing_time, cable_weight=10.0))
        self.supervisor._design["cable_weight"], self.supervisor._design["more"] = 10.0, more

    def weigh(self, tension, place=0.0, *, lost=()):
        """Read a tension [N] in a tick, where the mean payout is; return how long it must be averaged still [s]."""
        if not lost:
            self._mean.add(tension, place, unit_stands=False)
        mean = self._mean.mean
        self.step(tension_mean=mean.value, tension_sigma=mean.sigma, tension_time=mean.time, lost=lost)
        return float(self.supervisor._state["wait"][0])


def weighed(shares, *, more=0.0):
    """Return a braked winch whose cable has carried `shares` of the unit, and what it waited for."""
    braked = Braked(more=more)
    waits = [braked.weigh(10e3 + 10.0 * more + 50e3 * share) for share in shares]
    return braked, waits


@settings(max_examples=40, deadline=None)
@given(
    belief=st.floats(0.8, 1.2),
    swing=st.floats(0.0, 0.5),
    period=st.floats(5.0, 16.0),
    phase=st.floats(0.0, 6.28),
    more=st.floats(-500.0, 500.0),
)
def test_under_a_brake_a_unit_that_hangs_is_never_taken_for_one_that_stands(belief, swing, period, phase, more):
    """In a swell, near resonance, hauled in and lowered by hundreds of metres, and a fifth lighter than assumed."""
    time = np.arange(0.0, 60.0, DT)
    shares = np.maximum(belief * (1.0 + swing * np.sin(2.0 * math.pi / period * time + phase)), 0.0)
    assert weighed(shares, more=more)[0].landing.hangs


@settings(max_examples=40, deadline=None)
@given(
    mean=st.floats(0.0, 0.4),
    period=st.floats(5.0, 12.0),
    phase=st.floats(0.0, 6.28),
    more=st.floats(-500.0, 500.0),
)
def test_under_a_brake_a_unit_that_stands_is_known_within_seconds_and_is_waited_for(mean, period, phase, more):
    """Its rope is slack, or taut and pulled at by the waves that the ground lets it feel."""
    time = np.arange(0.0, 20.0, DT)
    shares = np.maximum(mean * (1.0 + np.sin(2.0 * math.pi / period * time + phase)), 0.0)
    braked, waits = weighed(shares, more=more)
    assert braked.landing.core.state["is_unloaded"][0]
    assert waits[-1] == 0.0
    assert waits[100] == pytest.approx(8.0 - 101 * DT) or np.mean(shares[:101]) > 0.59


def test_a_unit_that_is_hauled_up_hangs_again_and_one_whose_tension_is_held_has_landed():
    braked, _ = weighed([0.0] * 200)
    landing = braked.landing
    assert landing.core.state["is_unloaded"][0]
    for _ in range(159):
        braked.weigh(60e3, 5.0)
    assert landing.core.state["is_unloaded"][0]
    braked.weigh(60e3, 5.0)
    braked.weigh(60e3, 5.0)
    assert landing.hangs
    landing.begin_hold()
    assert landing.hangs
    landing = weighed([0.0] * 200)[0].landing
    landing.begin_hold()
    assert landing.unit_stands


@pytest.mark.parametrize("was_unloaded", [False, True])
@pytest.mark.parametrize("mean", [0.55, 0.65])
def test_a_mean_that_is_no_farther_from_the_limit_than_it_may_err_changes_nothing(mean, was_unloaded):
    """Waves of half the weight: sigma 0.35, of which a mean errs by 0.3, about 0.1; the limit is 0.6 of the weight."""
    braked, _ = weighed([0.0 if was_unloaded else 1.0] * 200)
    assert braked.landing.hangs is not was_unloaded
    for time in np.arange(0.0, 60.0, DT):
        braked.weigh(10e3 + 50e3 * (mean + 0.5 * math.sin(2.0 * math.pi / 8.0 * time)), 1.0)
    assert braked.landing.hangs is not was_unloaded
