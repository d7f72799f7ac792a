import math

import numpy as np
import pytest
from heave_node.interface.codes import MruStatus, SensorLevel
from heave_node.interface.sensors import MruReading
from heave_node.numerics.kinematics import smooth_ramp
from hypothesis import given
from hypothesis import strategies as st
from winch_controller_node.core.estimation.sense_design import STEPS
from winch_controller_node.core.estimation.sensor_health import lost_alarm
from winch_controller_node.interface.readings import ScalarReading
from winch_controller_node.parameters.laws import HealthParameters

from tests.gates import DepthJumps, EncoderGate, MruSteps, SensorGate, SensorTiming, judge_mru

DT = 0.05
OK, SUSPECT, LOST = SensorLevel


def make_gate(**timing):
    return SensorGate("depth", SensorTiming(DT, **timing), HealthParameters())


def feed(gate, values, start=1):
    """Give one reading per tick; None: none comes. Return the level after each tick."""
    levels = []
    for k, value in enumerate(values, start=start):
        if value is not None:
            gate.judge(k * DT, k * DT, (value,))
        gate.tick(k * DT)
        levels.append(gate.level)
    return levels


@pytest.mark.parametrize(
    ("fault", "reason"),
    [([math.nan] * 3, "nan"), ([2.1e4] * 3, "out of range"), ([7.0] * 3, "frozen"), ([None] * 4, "stale")],
)
def test_a_fault_raises_the_alarm_within_three_samples_and_is_named(fault, reason):
    """Stale is noticed when the fourth reading is overdue: three samples are missing then.

    The largest pressure of the contract, 200 MPa, is a depth of 19.9 km.
    """
    gate = make_gate()
    feed(gate, [0.1 * k for k in range(10)])
    assert gate.level == OK
    levels = feed(gate, fault, start=11)
    assert levels[-1] == LOST
    assert gate.reason == reason


@pytest.mark.parametrize("stamp", [0.05, 99.0])
@pytest.mark.parametrize("value", [math.nan, 7.0])
@pytest.mark.parametrize("status", ["", "status settling"])
def test_whatever_a_reading_is_refused_for_has_an_alarm_with_an_action(stamp, value, status):
    gate = make_gate()
    feed(gate, [6.0, 7.0, 7.0], start=0)
    gate.judge(3 * DT, stamp, (value,), status)
    lost = lost_alarm("mru", gate.reason, age=math.nan, limit=math.nan)
    assert lost.name == f"SENSOR_LOST, MRU: {gate.reason}"
    assert lost.row.action


@pytest.mark.parametrize("reason", ["status invalid", "status 7"])
def test_a_sensor_that_reports_a_fault_of_its_own_is_quoted(reason):
    alarm = lost_alarm("mru", reason, age=math.nan, limit=math.nan)
    assert (alarm.name, alarm.values) == ("SENSOR_LOST, MRU: status", {"status": reason})


def test_a_stale_sensor_is_reported_with_its_age_and_what_is_allowed():
    """No data since 0.1 s; the nominal period is 0.05 s, and three of them may be missing."""
    gate = make_gate()
    feed(gate, [7.0, 7.1, *[None] * 8])
    assert gate.alarm.name == "SENSOR_LOST, DEPTH: stale"
    limit = HealthParameters().stale_samples * DT
    stale = {"age": pytest.approx(0.5 - 0.1), "limit": pytest.approx(limit)}
    assert gate.alarm.values == stale
    feed(gate, [7.2], start=11)
    assert (gate.level, gate.alarm.values) == (LOST, stale), "the gap is shown until the sensor is used again"


def feed_every(gate, ticks, times, start):
    """Give readings every so many `ticks`, up to 40 ms old; return whether the sensor was ever lost."""
    was_lost = False
    for k in range(start, start + times * ticks):
        if k % ticks == 0:
            gate.judge(k * DT, k * DT - 0.02 * (k % 3), (0.1 * k,))
        gate.tick(k * DT)
        was_lost |= gate.is_lost
    return was_lost


@pytest.mark.parametrize("ticks", [1, 2, 3, 5])
def test_a_sensor_of_up_to_4_hz_is_judged_by_its_own_rate_from_its_first_reading_on(ticks):
    """Three of its own intervals may be missing, as of any sensor; 4 Hz is where the sea itself is not smooth."""
    gate = make_gate()
    assert not feed_every(gate, ticks, times=40, start=ticks)
    last = ticks * 40
    levels = feed(gate, [None] * (4 * ticks + 3), start=last + ticks)
    assert levels[0] == OK
    assert levels[-1] == LOST
    assert gate.reason == "stale"
    assert gate.is_newly_slow() is (ticks > 1)
    assert not gate.is_newly_slow(), "it is reported once"


def test_a_sensor_that_becomes_slow_is_stale_until_its_own_rate_is_known_and_then_serves():
    gate = make_gate()
    assert not feed_every(gate, 1, times=40, start=1)
    assert feed_every(gate, 5, times=20, start=45), "and 10 good readings make it well again"
    assert not feed_every(gate, 5, times=20, start=145)
    assert gate.slow_alarm.values["rate"] == pytest.approx(4.0, rel=0.1)


def test_a_sensor_slower_than_4_hz_is_stale_unless_its_rate_is_nominal():
    gate, stated = make_gate(), SensorGate("depth", SensorTiming(1.0), HealthParameters())
    assert feed_every(gate, 20, times=20, start=20)
    assert not feed_every(stated, 20, times=20, start=20)


def test_one_gap_of_a_fast_sensor_does_not_make_it_a_slow_one():
    gate = make_gate()
    feed(gate, [0.1 * k for k in range(20)])
    assert feed(gate, [None] * 10, start=21)[-1] == LOST
    feed(gate, [0.1 * k for k in range(31, 51)], start=31)
    assert gate.interval == DT
    assert not gate.is_newly_slow()


def test_an_encoder_that_stands_still_may_be_right_and_the_drum_is_to_be_looked_at_first():
    frozen = {name: lost_alarm(name, "frozen", age=0.0, limit=0.0).row for name in ("encoder", "mru", "depth")}
    assert frozen["mru"].action == frozen["depth"].action != frozen["encoder"].action


def test_one_bad_reading_makes_a_sensor_suspect_and_good_ones_make_it_well_again():
    gate = make_gate()
    feed(gate, [0.1, 0.2, math.nan])
    assert gate.level == SUSPECT
    feed(gate, [0.1 * k for k in range(4, 16)], start=4)
    assert (gate.level, gate.reason) == (OK, "")
    assert gate.state(1.0).refused == 1


@pytest.mark.parametrize(("stamp", "reason"), [(99.0, "wrong stamp"), (0.05, "late"), (math.nan, "wrong stamp")])
def test_a_stamp_from_the_future_or_the_past_or_none_at_all_is_refused(stamp, reason):
    gate = make_gate()
    feed(gate, [0.1, 0.2, 0.3])
    assert not gate.judge(4 * DT, stamp, (0.4,))
    # one stamp that cannot be says nothing of the readings after it
    assert gate.judge(5 * DT, 5 * DT, (0.5,))
    assert gate.reason == reason


def test_a_late_sensor_is_not_stale_while_its_usual_latency_lasts():
    gate = make_gate(latency=0.1)
    for k in range(3, 30):
        gate.judge(k * DT, (k - 2) * DT, (0.1 * k,))
        gate.tick(k * DT)
        assert gate.level == OK


@pytest.mark.parametrize(("is_spike", "level"), [(True, SUSPECT), (False, OK)])
def test_a_reading_outside_a_gate_is_a_spike_only_where_those_before_were_foreseen(is_spike, level):
    """A unit whose cable goes slack is not predicted: that is reported once, and not blamed on the depth sensor."""
    gate = make_gate()
    for k in range(3, 9):
        gate.judge(k * DT, k * DT, (0.1 * k,))
        gate.take_back(is_spike=is_spike)
        assert gate.level == level
    assert (gate.state(1.0).accepted, gate.state(1.0).refused) == (0, 6)


def test_an_mru_that_says_it_is_settling_is_not_used():
    gate = SensorGate("mru", SensorTiming(DT), HealthParameters())
    assert not judge_mru(gate, DT, MruReading(DT, 0.1, 0.0, status=MruStatus.SETTLING), MruSteps(), 0.0)
    assert gate.reason == "status settling"


@pytest.mark.parametrize("lasting", [1.0, 15.0])
def test_an_mru_that_was_frozen_is_read_again_once_it_moves(lasting):
    """A swell of 1 m and 9 s; what its rate makes of the heave meanwhile is no step: the heave stood."""
    gate, steps = SensorGate("mru", SensorTiming(DT), HealthParameters()), MruSteps()
    phases = 2.0 * np.pi / 9.0 * DT * np.arange(1200)
    frozen, last = 600, 600 + round(lasting / DT)
    taken = []
    for k, phase in enumerate(phases):
        held = phases[frozen] if frozen <= k < last else phase
        reading = MruReading(k * DT, np.sin(held), 2.0 * np.pi / 9.0 * np.cos(held))
        taken.append(judge_mru(gate, k * DT, reading, steps, 0.01))
    assert all(taken[:frozen])
    assert not any(taken[frozen + 10 : last])
    assert all(taken[last:])


@pytest.mark.parametrize(("stands", "is_lost"), [(240, False), (1000, False), (1201, True)])
def test_a_sensor_may_stand_for_a_minute_before_its_first_step(stands, is_lost):
    """A sea that rises from rest, by an MRU of 1 cm without noise: how large its steps are is not known yet.

    An MRU that is frozen from its start in a sea that moves is not confirmed, and the brake stays on.
    """
    gate, steps = SensorGate("mru", SensorTiming(DT), HealthParameters()), MruSteps()
    levels = []
    for k in range(stands + 400):
        growth = 0.05 * max(k - stands, 0) * DT
        phase = 2.0 * np.pi / 9.0 * k * DT
        heave, rate = growth * np.sin(phase), growth * np.cos(phase)
        judge_mru(gate, k * DT, MruReading(k * DT, round(heave, 2), round(rate, 2)), steps, 0.01)
        levels.append(gate.level)
    assert (LOST in levels) == is_lost
    assert levels[-1] == OK


def encoder_after(steps, rate=0.5):
    """Feed an encoder that moves at `rate`, with extra `steps` by tick; return payouts taken and the gate."""
    gate = EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT)
    position, taken = 0.0, []
    for k in range(1, 40):
        position += rate * DT + steps.get(k, 0.0)
        taken.append(gate.judge(k * DT, ScalarReading(k * DT, round(position, 3)), rate))
    return taken, gate


def test_an_encoder_jump_is_noticed_at_once_and_taken_off():
    """The drum turned on at 0.5 m/s: 39 ticks are 0.975 m, whatever the encoder says."""
    taken, gate = encoder_after({20: 0.2})
    assert taken[19] is None
    assert gate.offset == pytest.approx(0.2, abs=2e-3)
    assert taken[-1] == pytest.approx(0.975, abs=3e-3)
    assert gate.jumped_at == pytest.approx(20 * DT)

    def count_at(payout):
        return gate.scale * (payout + gate.offset)

    assert count_at(taken[-1]) == pytest.approx(1.175), "in the count that the encoder has now"
    gate.rescale(2.0, taken[-1])
    assert count_at(taken[-1]) == pytest.approx(1.175), "a scale that was wrong changes nothing of what is read"
    assert count_at(taken[-1] + 0.1) == pytest.approx(1.375)


def test_spikes_of_an_encoder_leave_no_offset_where_the_drum_goes_otherwise_than_the_winch_was_sent():
    """Thirty while the drum pays out, at 0.8 of what was sent: 1 cm each stayed in the payout, 31 cm in all."""
    gate, read = encoder_gate(), 0.0
    for k in range(1, 610):
        read = 0.42 * k * DT + 0.4 * (k % 20 == 19)
        gate.judge(k * DT, ScalarReading(k * DT, read), 0.42 / 0.8)
    assert gate.offset == pytest.approx(0.0, abs=1e-12)


def test_a_drum_that_follows_the_sea_through_a_gap_of_the_encoder_has_not_jumped():
    """0.8 s without readings, in which the drum turns round; then an old one comes, and in the next tick the newest."""
    gate = EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT)
    times = DT * np.arange(1, 200)
    payouts, rates = 0.6 * np.sin(times), 0.6 * np.cos(times)
    for tick, now in enumerate(times):
        expected = rates[max(tick - 1, 0)]
        gate.pass_tick(now, expected)
        if not 86 <= tick < 102:
            late = 9 if tick == 102 else 0
            gate.judge(now, ScalarReading(now - late * DT, payouts[tick - late]), expected)
    assert gate.offset == 0.0


def test_a_drum_that_turns_unseen_is_a_frozen_encoder():
    gate = EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT)
    for k in range(1, 6):
        gate.judge(k * DT, ScalarReading(k * DT, 1.0), 0.5)
    assert gate.gate.level == LOST
    assert gate.gate.reason == "frozen"


def test_a_count_that_freezes_while_the_drum_is_driven_slowly_is_found_though_the_estimate_comes_to_rest_with_it():
    gate, rate = EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT), 0.076
    for tick in range(1, 20):
        estimated = rate * math.exp(-tick * DT / 0.1)  # it goes by the count
        gate.judge(tick * DT, (tick * DT, 0.5), estimated, sent_rate=rate)
    assert gate.gate.reason == "frozen"


def test_an_encoder_with_play_in_its_gear_is_not_frozen_where_the_drum_turns_round():
    """A play of 1 cm, and a drum that is assumed a quarter faster and to answer 0.1 s sooner than it does."""
    gate, reading, play = EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT), 0.0, 0.005
    for time in DT * np.arange(1, round(40.0 / DT)):
        reading = min(max(reading, 0.6 * math.sin(0.7 * time) - play), 0.6 * math.sin(0.7 * time) + play)
        assumed = 1.25 * 0.42 * math.cos(0.7 * (time + 0.1))
        gate.judge(time, ScalarReading(time, 1e-3 * round(1e3 * reading)), assumed)
        assert gate.gate.level == OK


@pytest.mark.parametrize("play", [0.04, 0.06, 0.08])
def test_more_play_is_taken_for_a_frozen_encoder_once_and_then_known(play):
    """Three waves; the drum has gone on while it was taken up, and the encoder has not jumped."""
    gate, reading, lost = encoder_gate(), 0.0, []
    for k, payout in enumerate(payouts(range(1, round(27.0 / DT))), start=1):
        reading = min(max(reading, payout - 0.5 * play), payout + 0.5 * play)
        gate.judge(k * DT, ScalarReading(k * DT, reading), 0.42 * math.cos(0.7 * (k - 1) * DT))
        lost.append(gate.gate.is_lost)
    onsets = np.flatnonzero(np.diff(np.array(lost).astype(int)) == 1)
    assert len(onsets) == 1
    assert gate.play == pytest.approx(play, abs=0.02)
    assert gate.offset == 0.0


def test_a_drum_that_turns_late_once_is_no_fault():
    """Sent to turn back at 0.2 m/s it stands for 0.3 s, 6 cm, and then goes as it is sent."""
    gate, drum = encoder_gate(), 0.0
    for k in range(1, 201):
        rate = 0.2 if k <= 60 else -0.2
        drum += 0.0 if 60 < k <= 66 else rate * DT
        gate.judge(k * DT, ScalarReading(k * DT, drum), rate)
    assert gate.gate.level == OK
    assert gate.offset == 0.0


def test_a_gear_with_play_hides_no_frozen_encoder():
    """After the play is known it freezes in the middle of a turn: PLAY proves it there, 3 cm at 0.42 m/s."""
    gate, reading, play = encoder_gate(), 0.0, 0.03
    drum = payouts(range(1, round(27.5 / DT)))
    for k, payout in enumerate(drum, start=1):
        reading = min(max(reading, payout - play), payout + play)
        gate.judge(k * DT, ScalarReading(k * DT, reading), 0.42 * math.cos(0.7 * (k - 1) * DT))
    assert gate.play > 0.0
    assert gate.gate.level == OK
    _, levels = followed(gate, [reading] * 10, start=len(drum) + 1)
    assert levels.index(LOST) * DT <= 0.15


def test_a_braked_drum_is_not_a_frozen_encoder():
    gate = EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT)
    for k in range(1, 10):
        gate.judge(k * DT, ScalarReading(k * DT, 1.0), 0.5, is_driven=False)
    assert gate.gate.level == OK


def test_a_jump_that_was_taken_off_is_shown_until_diagnostics_have_told_it():
    """Diagnostics come once a second; the reading after the jump is good again."""
    gate = EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT)
    levels = []
    for k in range(1, 80):
        gate.judge(k * DT, ScalarReading(k * DT, 0.2 if k >= 20 else 0.0), 0.0)
        levels.append(gate.gate.level)
    assert levels[18] == OK
    assert levels[19 : 19 + round(1.5 / DT)] == [SUSPECT] * round(1.5 / DT)
    assert levels[-1] == OK
    assert gate.jump == pytest.approx(0.2)


def encoder_gate():
    return EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT)


PAYOUT = 5.0


def swung_payout(time):
    """Payout of a drum in a sea [m]: 0.6 m in 9 s, faster than MOVING_SPEED but for 0.34 s at each turn."""
    return PAYOUT + 0.6 * math.sin(0.7 * time)


def followed(gate, readings, start=1, *, is_driven=True, expected=None):
    """Give one of the `readings`, functions of time, per tick; return payouts taken and levels.

    The winch was sent what `swung_payout` does, or what is `expected`.
    """
    taken, levels = [], []
    for k, reading in enumerate(readings, start=start):
        rate = (swung_payout(k * DT) - swung_payout((k - 1) * DT)) / DT if expected is None else expected
        gate.pass_tick(k * DT, rate)
        taken.append(gate.judge(k * DT, ScalarReading(k * DT, reading), rate, is_driven=is_driven))
        gate.gate.tick(k * DT)
        levels.append(gate.gate.level)
    return taken, levels


def payouts(ticks):
    """Return what the drum does in `ticks` [m]."""
    return [swung_payout(k * DT) for k in ticks]


@pytest.mark.parametrize("factor", [0.5, -1.0, 2.0, 0.8])
@pytest.mark.parametrize("was", [1.0, -2.0])
def test_an_encoder_of_another_scale_goes_on_at_the_payout_that_is_given(factor, was):
    """From then on a step is one of the readings over both factors, and none of them has jumped."""
    gate = encoder_gate()
    if was != 1.0:
        gate.rescale(was, 0.0)
    read = [was * factor * payout for payout in payouts(range(1, 101))]
    for k in range(1, 51):
        gate.judge(k * DT, ScalarReading(k * DT, read[k - 1]), 0.0)
    gate.rescale(factor, swung_payout(50 * DT))
    assert gate.scale == was * factor
    offset = gate.offset
    taken, levels = followed(gate, read[50:], start=51)
    assert taken == pytest.approx(payouts(range(51, 101)), abs=1e-9)
    assert gate.offset == offset
    assert levels[-1] == OK


def test_an_encoder_without_a_reading_yet_is_rescaled_for_those_to_come():
    gate = encoder_gate()
    gate.rescale(2.0, 3.0)
    assert gate.judge(DT, ScalarReading(DT, 7.0), 0.0) == pytest.approx(3.5)


@pytest.mark.parametrize("factor", [-1.0, 0.5, -3.0])
def test_an_encoder_that_goes_otherwise_than_the_winch_was_sent_does_not_jump_again_and_again(factor):
    """It goes on as it went: at 0.42 m/s a step of an encoder turned over is 42 mm off, one of -3 times 84 mm."""
    gate = encoder_gate()
    taken, levels = followed(gate, [factor * payout for payout in payouts(range(1, 401))])
    assert LOST not in levels
    assert taken.count(None) <= 1
    steps = np.diff([payout for payout in taken if payout is not None][1:])
    assert max(np.abs(steps)) == pytest.approx(abs(factor) * 0.42 * DT, rel=0.02)


def test_one_that_goes_the_other_way_from_some_moment_on_jumps_once():
    """From the middle of the drum's turn, where it is fastest: by twice the payout that it had, and then no more."""
    gate = encoder_gate()
    turned = [payout if k < 180 else -payout for k, payout in enumerate(payouts(range(1, 401)))]
    taken, levels = followed(gate, turned)
    assert LOST not in levels
    assert taken.count(None) <= 2
    assert gate.offset == pytest.approx(-2.0 * swung_payout(181 * DT), abs=4.0 * 0.42 * DT)


def frozen_gate(until=60):
    """Return a gate whose encoder has stood still since tick 20, and where it did [m]."""
    gate, stuck = encoder_gate(), swung_payout(20 * DT)
    followed(gate, payouts(range(1, 21)))
    _, levels = followed(gate, [stuck] * (until - 20), start=21)
    assert levels[-1] == LOST
    assert gate.gate.reason == "frozen"
    return gate, stuck


def test_a_frozen_encoder_stays_frozen_while_the_drum_is_slow_turns_round_or_is_braked():
    """Three waves; then the winch is sent nothing; then it brakes."""
    gate, stuck = frozen_gate()
    _, levels = followed(gate, [stuck] * 540, start=61)
    assert set(levels) == {LOST}
    _, levels = followed(gate, [stuck] * 200, start=601, expected=0.0)
    assert set(levels) == {LOST}
    _, levels = followed(gate, [stuck] * 200, start=801, expected=0.0, is_driven=False)
    assert set(levels) == {LOST}


def test_a_drum_that_turns_back_before_its_encoder_is_frozen_takes_no_proof_away():
    """Slower than MOVING_SPEED near its turn at 2.24 s the drum proves nothing; after it, it does so at once.

    It has gone PLAY, 3 cm, 0.49 s after the turn: 0.6 (1 - cos(0.7 t)).
    """
    gate, turn = encoder_gate(), round(math.pi / 2.0 / 0.7 / DT)
    followed(gate, payouts(range(1, turn + 1)))
    _, levels = followed(gate, [swung_payout(turn * DT)] * 40, start=turn + 1)
    assert levels.index(LOST) * DT == pytest.approx(0.45, abs=DT)


def test_a_drum_that_is_slow_for_a_moment_again_and_again_takes_no_proof_away():
    """Two ticks at 0.5 m/s, one at rest: three in which it turned are four ticks, and PLAY is gone after two."""
    gate, frozen = encoder_gate(), []
    for k in range(8):
        gate.judge(k * DT, ScalarReading(k * DT, 1.0), 0.0 if k % 3 == 0 else 0.5)
        frozen.append(gate.gate.level == LOST)
    assert frozen.index(True) == 4


@pytest.mark.parametrize("until", [60, 200, 470])
def test_a_frozen_encoder_is_good_again_once_it_moves_and_the_payout_is_right_then(until):
    """One that kept its sight reads what the drum has done meanwhile; the winch was sent just that."""
    gate, _ = frozen_gate(until)
    taken, levels = followed(gate, payouts(range(until + 1, until + 41)), start=until + 1)
    assert taken == pytest.approx(payouts(range(until + 1, until + 41)), abs=1e-9)
    assert gate.offset == pytest.approx(0.0, abs=1e-9)
    assert levels[-1] == OK


@given(st.integers(20, 400), st.integers(1, 600), st.floats(0.9, 1.1))
def test_an_encoder_that_freezes_and_counts_on_has_missed_at_most_a_fifth_of_the_path(frozen, ticks, gain):
    """It counts on from where it stood: what the drum did meanwhile is known by what the winch was sent.

    The drum does up to a tenth more or less than that. Where it came back nearly to where it was, nothing is reported.
    """
    gate = encoder_gate()
    drum = [gain * payout for payout in payouts(range(1, frozen + ticks + 61))]
    followed(gate, drum[:frozen])
    followed(gate, [drum[frozen - 1]] * ticks, start=frozen + 1)
    missed = drum[frozen + ticks - 1] - drum[frozen - 1]
    taken, levels = followed(gate, [payout - missed for payout in drum[frozen + ticks :]], start=frozen + ticks + 1)
    path = float(np.sum(np.abs(np.diff(payouts(range(frozen, frozen + ticks + 2))))))
    # whether it froze or not: what a gear takes up where the drum turns round, gone unseen, proves nothing
    allowed = HealthParameters().encoder_step + max(0.2 * path, STEPS["largest_play"] + 0.42 * DT) + 0.1 * path
    errors = [abs(one - true) for one, true in zip(taken, drum[frozen + ticks :], strict=True) if one is not None]
    assert len(errors) >= 58
    assert max(errors) < allowed
    assert levels[-1] == OK


def test_an_operator_who_trusts_a_frozen_encoder_has_it_go_on_where_the_drum_got_to():
    """It has stood still since 1 s; at 3 s the winch has gone by swung_payout(3) - swung_payout(1)."""
    gate, stuck = frozen_gate()
    gate.trust()
    taken, levels = followed(gate, [stuck] * 10, start=61, expected=0.0)
    assert taken == pytest.approx([swung_payout(60 * DT)] * 10, abs=1e-9)
    assert levels[-1] == OK
    # moved on from there it counts on
    taken, _ = followed(gate, [stuck + 0.01 * k for k in range(1, 11)], start=71, expected=0.01 / DT)
    assert taken[-1] == pytest.approx(swung_payout(60 * DT) + 0.1, abs=1e-9)


def test_to_trust_an_encoder_that_is_well_changes_nothing():
    gate = encoder_gate()
    followed(gate, payouts(range(1, 41)))
    gate.trust()
    taken, levels = followed(gate, payouts(range(41, 81)), start=41)
    assert taken == pytest.approx(payouts(range(41, 81)))
    assert set(levels) == {OK}


def heave(time):
    """Depth of a unit that swings by 1 m in 9 s [m]."""
    return 900.0 + math.sin(0.7 * time)


@pytest.mark.parametrize("jump", [3.0, -0.8, 50.0])
def test_a_jump_of_the_depth_is_taken_off_and_one_back_leaves_nothing(jump):
    jumps, times = DepthJumps(), 0.1 * np.arange(300)
    read = [jumps.take_off(time, heave(time) + (jump if 10.0 <= time < 20.0 else 0.0)) for time in times]
    assert read.count(None) <= 2
    errors = [depth - heave(time) for time, depth in zip(times, read, strict=True) if depth is not None]
    # what the unit itself has moved between two readings is counted to the jump
    assert max(np.abs(errors)) < 0.08
    assert jumps.offset == 0.0
    assert errors[-1] == 0.0


@pytest.mark.parametrize(
    ("factor", "offset", "is_like_scale"),
    [(-1.0, 0.0, True), (0.5, 0.0, True), (1.2, 0.0, True), (1.05, 0.0, False), (1.0, 3.0, False), (1.0, -80.0, False)],
)
def test_a_jump_as_large_as_that_of_another_scale_or_sign_must_be_proved(factor, offset, is_like_scale):
    """From the reading on that goes on from it; one back to the first place is none."""
    jumps, times = DepthJumps(), 0.1 * np.arange(40)
    unproved = []
    for k, time in enumerate(times):
        is_wrong = 10 <= k < 30
        jumps.take_off(time, factor * heave(time) + offset if is_wrong else heave(time))
        unproved.append(jumps.is_unproved)
    assert unproved[11] is is_like_scale
    assert not any(unproved[:11])
    assert not any(unproved[30:])


def test_a_spike_of_the_depth_however_large_leaves_nothing_to_prove():
    jumps, times = DepthJumps(), 0.1 * np.arange(100)
    for k, time in enumerate(times):
        jumps.take_off(time, -heave(time) if k == 50 else heave(time))
        assert not jumps.is_unproved


@pytest.mark.parametrize(("noise", "is_left_out"), [(0.0, True), (0.02, True), (0.2, False)])
def test_a_step_of_the_depth_that_its_noise_makes_is_no_jump(noise, is_left_out):
    jumps = DepthJumps()
    read = [jumps.take_off(0.1 * k, 900.0 + (1.0 if k == 5 else 0.0), noise) for k in range(10)]
    assert (read[5] is None) is is_left_out


@given(st.lists(st.floats(-0.4, 0.4), min_size=1, max_size=100))
def test_steps_that_a_unit_can_make_are_never_taken_off(steps):
    jumps = DepthJumps()
    depths = 900.0 + np.cumsum([0.0, *steps])
    assert [jumps.take_off(0.1 * k, depth) for k, depth in enumerate(depths)] == list(depths)


def test_readings_that_come_and_are_too_old_are_late_since_when_and_by_how_much_and_not_missing():
    """Stamps 0.92 s behind the controller's clock, 20 readings a second."""
    gate = make_gate()
    for k in range(1, 200):
        assert gate.judge(k * DT, k * DT - 0.92, (0.1 * k,))
        gate.tick(k * DT)
    assert (gate.level, gate.reason) == (LOST, "delayed")
    limit = HealthParameters().stale_samples * DT
    values = {"age": pytest.approx(0.92), "limit": pytest.approx(limit), "since": pytest.approx(DT)}
    assert (gate.alarm.name, gate.alarm.values) == ("SENSOR_LOST, DEPTH: delayed", values)
    feed(gate, [None] * 8, start=200)
    assert gate.alarm.name == "SENSOR_LOST, DEPTH: stale", "nothing comes now"


@pytest.mark.parametrize(("resolution", "within"), [(0.0, 1.0), (0.01, 4.0)])
def test_an_mru_whose_heave_stands_while_its_attitude_goes_on_is_frozen_and_not_scaled(resolution, within):
    """One that reads whole centimetres, in a sea of 0.3 m, is not."""
    gate, steps = SensorGate("mru", SensorTiming(DT), HealthParameters()), MruSteps()
    lost = []
    for tick in range(1, 1200):
        time = tick * DT
        moved = min(time, 40.0)
        read = 0.3 * math.sin(0.8 * moved), 0.24 * math.cos(0.8 * moved)
        heave, rate = (round(value / resolution) * resolution if resolution else value for value in read)
        attitude = (0.02 * math.sin(0.7 * time), 0.01 * math.cos(0.6 * time))
        reading = MruReading(time=time, heave=heave, heave_rate=rate, roll=attitude[0], pitch=attitude[1])
        judge_mru(gate, time, reading, steps, 0.01)
        lost += [time] if gate.is_lost else []
    assert lost
    assert 40.0 < lost[0] < 40.0 + within
    assert gate.reason == "frozen"


def heave_in_steps(step, seed, amplitude=0.3):
    """Return heave of a sea of 8 s, 20 readings a second for 420 s, rounded to a `step` [m]."""
    rng = np.random.default_rng(seed)
    times, omegas = np.arange(1, 420 * 20 + 1) / 20.0, 2.0 * np.pi / 8.0 * np.linspace(0.6, 1.8, 20)
    sizes = np.exp(-(((np.linspace(0.6, 1.8, 20) - 1.0) / 0.25) ** 2))
    sizes *= amplitude * math.sqrt(2.0) / np.linalg.norm(sizes)
    phases = rng.uniform(0.0, 2.0 * np.pi, 20)
    return times, np.round(np.sin(np.outer(times, omegas) + phases) @ sizes / step) * step


def times_lost(times, heaves):
    """Return when the MRU was taken for lost, one of heave alone [s]."""
    gate, lost, was_lost = SensorGate("mru", SensorTiming(DT), HealthParameters()), [], False
    for time, heave in zip(times, heaves, strict=True):
        gate.judge(time, time, (heave, 0.0, 0.0, 0.0))
        gate.tick(time)
        lost += [time] if gate.is_lost and not was_lost else []
        was_lost = gate.is_lost
    return lost


@pytest.mark.parametrize("step", [0.01, 0.001])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_an_mru_that_reads_in_steps_is_not_frozen_at_the_crests_of_the_sea(step, seed):
    """A run of equal readings at a crest is longer than chance has it; of a parabola it is 4.8 times the run before."""
    assert len(times_lost(*heave_in_steps(step, seed))) <= 1


def test_an_mru_of_a_millimetre_in_a_large_sea_is_not_frozen_at_the_flattest_crests():
    """Where it reads the same five times in a row once in minutes: two in a row before show that it reads in steps."""
    assert not any(times_lost(*heave_in_steps(0.001, seed, amplitude=1.0)) for seed in range(1, 7))


@pytest.mark.parametrize("ramp", [60.0, 120.0, 300.0])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_an_mru_that_reads_in_steps_is_not_frozen_while_a_sea_rises_from_rest(ramp, seed):
    """It is 1 to 4 steps high then, whose crests stand for seconds; what has stood so long before is no measure.

    Of 9 seas one has a lull later that stands for 8 s, at 132 s.
    """
    times, heaves = heave_in_steps(1e-6, seed)
    weights = np.array([smooth_ramp(time, ramp)[0] for time in times])
    assert not [time for time in times_lost(times, np.round(weights * heaves, 2)) if time < 130.0]


@pytest.mark.parametrize("step", [0.01, 0.001])
def test_an_mru_that_reads_in_steps_and_freezes_is_found_before_prediction_ends(step):
    times, heaves = heave_in_steps(step, 1)
    frozen = np.where(times > 300.0, heaves[times <= 300.0][-1], heaves)
    assert 0.0 < times_lost(times, frozen)[-1] - 300.0 <= 1.5


@pytest.mark.parametrize("travel", [0.0, 0.02, 0.049])
def test_a_sensor_that_falls_silent_is_stale_and_not_delayed_by_the_time_that_its_readings_travel(travel):
    gate = make_gate()
    for k in range(1, 40):
        if k < 20:
            gate.judge(k * DT, k * DT - travel, (0.1 * k,))
        gate.tick(k * DT)
        assert gate.level == OK or gate.reason == "stale"
    assert gate.level == LOST


@pytest.mark.parametrize(("factor", "lasting", "stays"), [(0.3, 60, 0.0), (1.0, 200, 0.6)])
def test_an_encoder_that_is_used_again_counts_as_before_it_jumped_where_that_is_where_the_drum_is(
    factor, lasting, stays
):
    """A scale of 0.3 for 3 s on 5 m: jumps taken off at both ends leave the way that was not counted, 0.42 m."""
    gate, rate, payout = EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT), 0.2, 0.0
    for tick in range(1, 200):
        payout = 5.0 + rate * DT * tick
        wrong = 50 <= tick < 50 + lasting
        reading = (factor * payout if wrong else payout) + stays * wrong
        gate.pass_tick(tick * DT, rate)
        counted = gate.judge(tick * DT, (tick * DT, reading), rate)
    assert counted == pytest.approx(payout - (0.42 if factor < 1.0 else 0.0), abs=0.02)
    gate.resume(payout)
    counted = gate.judge(200 * DT, (200 * DT, reading + rate * DT), rate)
    assert counted == pytest.approx(payout + rate * DT, abs=0.02), "one that stays off goes on without its jump"
