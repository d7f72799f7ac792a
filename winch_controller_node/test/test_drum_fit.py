"""The winch as its set-points and its encoder show it: what a virtual winch is, within the stated sigmas."""

from dataclasses import replace

import numpy as np
import pytest
from cable_sim_node.winch.component import VirtualWinch, WinchCommand
from cable_sim_node.winch.parameters import EncoderParameters, WinchParameters
from heave_core.watch import Drum, drum_records, sent_points
from hypothesis import given, settings
from hypothesis import strategies as st
from winch_controller_node.adviser.drum.drum_fit import LIMITS, _improbability, fit_drum, prior_of
from winch_controller_node.adviser.drum.drum_record import FACTOR, DrumRecord
from winch_controller_node.adviser.drum.drum_search import ALWAYS, PRICES, begun, identify
from winch_controller_node.adviser.record import SensorHistory
from winch_controller_node.adviser.winch import WinchIdentifier
from winch_controller_node.beliefs.drum import drum_of
from winch_controller_node.interface.observations import TICK_COLUMNS
from winch_controller_node.node_parameters import WinchControllerParameters

DT = 0.05
AHEAD = 20
BELIEF = WinchControllerParameters()
PLACE = {name: place for place, name in enumerate(Drum._fields)}
PRIOR = prior_of(BELIEF)
NOMINAL = np.array([*drum_of(BELIEF.winch), 1.0])


def waves(seconds, size, noise=0.02, seed=1):
    """Return set-points of two waves and a little noise, at most some 1.5 times `size` [m/s]."""
    time, random = DT * np.arange(round(seconds / DT)), np.random.default_rng(seed)
    return size * (np.sin(0.7 * time) + 0.5 * np.sin(1.1 * time)) + noise * random.standard_normal(len(time))


def driven(winch, rates, tensions=None):
    """Drive a virtual winch by rate set-points; return its encoder at the end of each tick, and its states."""
    virtual = VirtualWinch(winch, tick_period=DT, seed=1)
    virtual.step(0, WinchCommand(1))
    under = np.full(len(rates), np.nan) if tensions is None else tensions
    states = [
        virtual.step(tick, WinchCommand(tick + 1, 0.0, float(rate)), float(tension))
        for tick, (rate, tension) in enumerate(zip(rates, under, strict=True), start=1)
    ]
    return np.array([state.encoder_payout for state in states]), states


def recorded(rates, readings, limited=(), tensions=None):
    """Return the record of `readings` of a drum that was sent `rates`, its first second left out as orders before it.

    Those readings are `limited` in whose ticks the winch says that a limit acted.
    """
    none = np.zeros(len(rates))
    tensions = np.full(len(rates), np.nan) if tensions is None else tensions
    was_limited = np.isin(np.arange(len(rates)), limited)
    return DrumRecord(none, rates, none, tensions, np.array(readings[AHEAD:]), was_limited[AHEAD:], 0.0, DT)


def record_of(winch, seconds=30.0, size=0.6, seed=1):
    """Return the record of a virtual winch."""
    rates = waves(seconds, size, seed=seed)
    readings, states = driven(winch, rates)
    return recorded(rates, readings, [tick for tick, state in enumerate(states) if state.limits_hit])


def sigma_of(found, name):
    return found.sigmas[found.free.index(PLACE[name])]


@settings(max_examples=12)
@given(
    lag=st.floats(0.05, 0.4),
    delay=st.floats(0.08, 0.35),
    gain=st.floats(0.75, 1.3),
    size=st.sampled_from([0.3, 0.8]),
    seed=st.integers(0, 2**31),
)
def test_lag_delay_and_gain_are_known_within_their_sigmas(lag, delay, gain, size, seed):
    """From an encoder of 1 mm; belief 0.15 s, 0.2 s, 1."""
    truth = WinchParameters(time_constant=lag, command_delay=delay, speed_gain=gain)
    found = identify(record_of(truth, size=size, seed=seed), PRIOR, NOMINAL)
    for name, value in (("lag", lag), ("delay", delay), ("gain", gain)):
        assert abs(found.theta[PLACE[name]] - value) < 4.0 * sigma_of(found, name) + 1e-3, name
    assert max(found.sigmas) < 0.05
    assert not set(found.free) & {*LIMITS, FACTOR}


@pytest.mark.parametrize(
    ("winch", "field", "value"),
    [
        ({"speed_limit": 1.0}, "speed_out", 1.0),
        ({"hauling_speed_share": 0.4}, "speed_in", 0.8),
        ({"acceleration_limit": 0.6, "stop_deceleration": 0.6}, "acceleration_out", 0.6),
        ({"hauling_acceleration_share": 0.4}, "acceleration_in", 0.6),
        ({"speed_deadband": 0.05}, "deadband", 0.05),
        ({"encoder": EncoderParameters(backlash=0.02)}, "backlash", 0.02),
    ],
    ids=["speed out", "speed in", "acceleration out", "acceleration in", "dead zone", "play"],
)
def test_a_limit_a_dead_zone_or_play_is_freed_and_known(winch, field, value):
    """Limits to 2 %: what the virtual winch does within a step of its own is not in the model."""
    found = identify(record_of(WinchParameters(**winch), size=1.4), PRIOR, NOMINAL)
    assert PLACE[field] in found.free
    assert found.theta[PLACE[field]] == pytest.approx(value, rel=0.02, abs=4.0 * sigma_of(found, field) + 2e-3)
    assert (found.theta[PLACE["lag"]], found.theta[PLACE["delay"]]) == pytest.approx((0.15, 0.2), abs=0.02)
    assert found.theta[PLACE["gain"]] == pytest.approx(1.0, abs=0.02)
    assert found.residual < 2e-3


@pytest.mark.parametrize(("power", "swing"), [(25e3, 0.5), (60e3, 0.3), (60e3, 0.9)])
def test_a_limit_of_the_power_is_freed_and_known_by_the_tension(power, swing):
    """Its speed goes with the tension: taken for a constant limit of the speed, it is wrong with every wave.

    The tension is that at the start of each tick, as the virtual winch has it, and known at its end.
    """
    rates = waves(30.0, 0.9)
    tensions = 1e5 * (1.0 + swing * np.sin(0.9 * DT * np.arange(len(rates))))
    readings, states = driven(WinchParameters(power_limit=power), rates, tensions)
    limited = [tick for tick, state in enumerate(states) if state.limits_hit]
    found = identify(recorded(rates, readings, limited, np.append(tensions[1:], tensions[-1])), PRIOR, NOMINAL)
    assert set(found.free) & set(LIMITS) == {PLACE["power"]}
    assert found.theta[PLACE["power"]] == pytest.approx(power, rel=0.02)
    assert (found.theta[PLACE["lag"]], found.theta[PLACE["delay"]]) == pytest.approx((0.15, 0.2), abs=0.02)
    assert found.residual < 2e-3


def test_of_a_power_that_no_tension_shows_nothing_is_found():
    """A limit of the speed alone explains as much, and what is read does not say that it is one of the power."""
    readings, states = driven(WinchParameters(power_limit=6e4), (rates := waves(30.0, 0.9)), np.full(600, 1e5))
    found = identify(recorded(rates, readings, [i for i, one in enumerate(states) if one.limits_hit]), PRIOR, NOMINAL)
    assert set(found.free) & set(LIMITS) == {PLACE["speed_out"], PLACE["speed_in"]}


def crept(gain, hauling, creep, seconds=30.0, lag=0.15):
    """Return the record of a drum whose speed loop has no integral part, without a delay: exact by its exponential."""
    rates, payout, rate, readings = waves(seconds, 0.5), 0.0, 0.0, []
    for set_point in rates:
        end = gain * (set_point if set_point > 0.0 else hauling * set_point) + creep
        change = -(end - rate) * np.expm1(-DT / lag)
        payout, rate = payout + end * DT - lag * change, rate + change
        readings.append(1e-3 * round(1e3 * payout))
    return recorded(rates, readings)


@pytest.mark.parametrize(("hauling", "creep"), [(0.76, 0.058), (1.3, -0.04), (1.0, 0.05)])
def test_a_drum_that_creeps_and_hauls_in_with_another_gain_is_known(hauling, creep):
    winch = replace(BELIEF.winch, command_delay=0.0)
    prior = prior_of(replace(BELIEF, winch=winch))
    found = identify(crept(0.94, hauling, creep), prior, np.array([*drum_of(winch), 1.0]))
    assert found.theta[PLACE["gain"]] == pytest.approx(0.94, abs=0.01)
    assert found.theta[PLACE["hauling"]] == pytest.approx(hauling, abs=0.02)
    assert found.theta[PLACE["creep"]] == pytest.approx(creep, abs=0.005)
    assert not set(found.free) & set(LIMITS)


def scaled_from(factor, before_end, limited=(), **winch):
    """Return the record of a winch whose encoder counts `factor` times as much for the last `before_end` [s]; onset."""
    rates = waves(30.0, 0.6)
    readings, states = driven(WinchParameters(**winch), rates)
    onset, drum = len(rates) - round(before_end / DT), np.array([state.payout for state in states])
    # it counts on from where it stood
    readings[onset:] = readings[onset - 1] + factor * (drum[onset:] - drum[onset - 1])
    return recorded(rates, readings, limited), onset - AHEAD


@pytest.mark.parametrize("before_end", [1.5, 3.0, 6.0, 11.0])
@pytest.mark.parametrize("factor", [0.5, 0.75, 2.0])
def test_an_encoder_that_changes_its_factor_is_known_with_its_onset(factor, before_end):
    """A drum's gain does not jump: what does is the encoder's."""
    record, onset = scaled_from(factor, before_end)
    found = identify(record, PRIOR, NOMINAL)
    assert FACTOR in found.free
    assert found.theta[FACTOR] == pytest.approx(factor, rel=0.03)
    assert found.record.onset == pytest.approx(onset, abs=4)
    assert not set(found.free) & set(LIMITS)


@pytest.mark.parametrize("before_end", [1.6, 3.0, 8.0])
@pytest.mark.parametrize(("creep", "size"), [(-0.03, 0.1), (0.06, 0.1), (0.1, 0.6)])
def test_a_drum_that_begins_to_creep_is_no_other_scale_of_its_encoder(creep, size, before_end):
    rates = waves(30.0, size)
    readings, _ = driven(WinchParameters(), rates)
    crept = creep * np.maximum(DT * np.arange(len(rates)) - (30.0 - before_end), 0.0)
    record = recorded(rates, 1e-3 * np.round(1e3 * (readings + crept)))
    assert FACTOR not in identify(record, PRIOR, NOMINAL).free


@pytest.mark.parametrize("before_end", [1.6, 2.0, 3.0])
@pytest.mark.parametrize("speed", [0.107, -0.15])
def test_a_creep_beside_a_steady_speed_may_be_either_and_no_scale_of_the_encoder_is_found(speed, before_end):
    """v + 0.035 m/s is 1.33 v as well: they differ by hundredths of a nat, and five decide."""
    time = DT * np.arange(len(waves(30.0, 0.1)))
    rates = np.interp(time, [20.0, 21.5], [0.0, speed])
    readings, _ = driven(WinchParameters(), rates)
    crept = 0.035 * np.maximum(time - (30.0 - before_end), 0.0)
    record = recorded(rates, 1e-3 * np.round(1e3 * (readings + crept)))
    assert FACTOR not in identify(record, PRIOR, NOMINAL).free


@pytest.mark.parametrize("lasts", [2.0, 4.24, 9.0])
def test_a_count_that_has_drifted_for_a_while_is_explained_by_a_drift_as_one_that_drifts_still(lasts):
    """Ends are tried each half second: of what is left of the squares, that leaves some thousandths."""
    rates = waves(30.0, 0.4)
    record = recorded(rates, driven(WinchParameters(), rates)[0])
    time, begin = DT * np.arange(len(record.readings)), 20.0
    left = 0.043 * np.clip(time - begin, 0.0, lasts)
    nothing_free = np.empty((len(left), 0))
    assert record.squares_with_drift(left, nothing_free, record.readings, round(begin / DT)) < 0.005 * left @ left


@pytest.mark.parametrize("before_end", [3.0, 8.0, 14.0])
@pytest.mark.parametrize(("gain", "size"), [(1.02, 0.8), (0.96, 0.4), (1.04, 0.8)])
def test_a_drum_whose_gain_begins_to_drift_is_no_other_scale_of_its_encoder(gain, size, before_end):
    """The count is the sum of the drum's steps times a gain that goes with time; a scale goes there at once."""
    rates = waves(30.0, size)
    _, states = driven(WinchParameters(), rates)
    since = np.maximum(DT * np.arange(len(rates)) - (30.0 - before_end), 0.0)
    steps = np.diff([state.payout for state in states], prepend=0.0)
    readings = np.cumsum((1.0 + (gain - 1.0) * since / before_end) * steps)
    assert FACTOR not in identify(recorded(rates, 1e-3 * np.round(1e3 * readings)), PRIOR, NOMINAL).free


@pytest.mark.parametrize(
    ("drift", "size", "end", "ago"),
    [(-0.002, 0.8, 25.0, 2.0), (0.002, 0.8, 30.0, 4.0), (-0.0015, 0.5, 35.0, 2.0), (-0.003, 0.3, 30.0, 2.0)],
)
def test_a_drum_whose_gain_goes_on_drifting_is_no_other_scale_of_its_encoder(drift, size, end, ago):
    """By `drift` a second since 15 s, while it is assumed as some seconds `ago`: a part of it was taken for a lag."""
    rates = waves(50.0, size)
    _, states = driven(WinchParameters(), rates)
    gain = 1.0 + drift * np.maximum(DT * np.arange(len(rates)) - 15.0, 0.0)
    readings = 1e-3 * np.round(1e3 * np.cumsum(gain * np.diff([state.payout for state in states], prepend=0.0)))

    def record(until):
        ticks = slice(max(round((until - 21.0) / DT), 0), round(until / DT))
        return recorded(rates[ticks], readings[ticks])

    before, assumed = record(end - ago), NOMINAL.copy()
    assumed[list(ALWAYS)] = fit_drum(before, PRIOR, begun(before, NOMINAL), ALWAYS).theta[list(ALWAYS)]
    assert FACTOR not in identify(record(end), PRIOR, assumed).free


@pytest.mark.parametrize("before_end", [1.5, 3.0, 6.0, 11.0])
@pytest.mark.parametrize("factor", [-1.0, 0.0, 0.2, 3.0])
def test_an_encoder_that_is_reversed_still_or_of_another_kind_of_scale_is_no_scale_to_correct(
    excerpt_of, factor, before_end
):
    """Half to twice is a scale: another gear, or a count taken once for twice. Beyond it the sensor is not one."""
    *_, excerpt = excerpts(excerpt_of, WinchParameters(), 25.0)
    onset, column = len(excerpt.ticks) - round(before_end / DT), TICK_COLUMNS.index("encoder")
    ticks = excerpt.ticks.copy()
    start = ticks[onset, column]
    ticks[onset:, column] = start + factor * (ticks[onset:, column] - start)
    answer = WinchIdentifier(BELIEF, DT).look(replace(excerpt, ticks=ticks), SensorHistory(), {})
    assert answer is None or answer.factor is None


@pytest.mark.parametrize(("factor", "gain", "is_scale"), [(1.93, 1.0, True), (1.93, 1.24, False), (0.6, 0.7, False)])
def test_a_scale_of_the_encoder_is_within_its_range_with_the_gain_that_was_found_beside_it(
    excerpt_of, factor, gain, is_scale
):
    """Of 2.4 times as much, 1.93 of a scale and 1.24 of a gain: the encoder reads the product since then."""
    *_, excerpt = excerpts(excerpt_of, WinchParameters(), 25.0)
    record, _ = scaled_from(factor, 6.0)
    found = fit_drum(record, PRIOR, begun(record, NOMINAL), (PLACE["gain"], FACTOR))
    theta = found.theta.copy()
    theta[[PLACE["gain"], FACTOR]] = gain, factor
    found = replace(found, theta=theta, squares=0.0)
    answer = WinchIdentifier(BELIEF, DT)._answer(found, found, NOMINAL, excerpt)
    assert (answer.factor is not None) == is_scale


def test_an_encoder_whose_newest_reading_was_not_accepted_is_not_identified(excerpt_of):
    """It is lost, frozen or has jumped: what it read in the second before may not be the drum."""
    *_, excerpt = excerpts(excerpt_of, WinchParameters(time_constant=0.4), 15.0)
    ticks = excerpt.ticks.copy()
    ticks[-1, TICK_COLUMNS.index("encoder")] = np.nan
    assert WinchIdentifier(BELIEF, DT).look(excerpt, SensorHistory(), {}) is not None
    assert WinchIdentifier(BELIEF, DT).look(replace(excerpt, ticks=ticks), SensorHistory(), {}) is None


@pytest.mark.parametrize(("every", "is_found"), [(5, False), (20, True)])
def test_an_encoder_is_not_blamed_where_the_winch_was_often_at_a_limit(every, is_found):
    """In a fifth of the ticks, twice LIMITED, or in a twentieth, half of it: what is read is the same."""
    record, _ = scaled_from(0.5, 6.0, limited=range(0, 600, every))
    assert (FACTOR in identify(record, PRIOR, NOMINAL).free) is is_found


@pytest.mark.parametrize("is_known", [False, True])
def test_an_encoder_is_not_blamed_where_the_drum_was_not_as_believed_before(is_known):
    """A winch of 0.7 of its gain is weak before its encoder is wrong; once that is assumed the encoder may be."""
    record, _ = scaled_from(0.5, 6.0, speed_gain=0.7)
    known = {"winch.speed_gain": 0.7} if is_known else {}
    found = identify(record, PRIOR, np.array([*drum_of(BELIEF.winch, known), 1.0]))
    assert (FACTOR in found.free) is is_known


HALVED = {"speed_limit": 1.0, "acceleration_limit": 0.75, "stop_deceleration": 0.75}
"""Half of the virtual winch's 2 m/s and 1.5 m/s^2."""


@pytest.mark.parametrize("seed", [1, 3])
@pytest.mark.parametrize(("size", "limits"), [(0.6, {}), (1.4, HALVED)], ids=["alone", "with halved limits"])
def test_a_servo_ten_times_as_slow_as_stated_is_found(size, limits, seed):
    """1.5 s for 0.15 s: 27 of the prior's sigmas of 0.05 s away."""
    found = identify(record_of(WinchParameters(time_constant=1.5, **limits), size=size, seed=seed), PRIOR, NOMINAL)
    assert found.theta[PLACE["lag"]] == pytest.approx(1.5, rel=0.03)
    assert found.theta[PLACE["gain"]] == pytest.approx(1.0, rel=0.03)
    assert FACTOR not in found.free
    shown = {"speed_out": 1.0, "speed_in": 1.0, "acceleration_out": 0.75, "acceleration_in": 0.75} if limits else {}
    assert {name: found.theta[PLACE[name]] for name in shown} == pytest.approx(shown, rel=0.03)
    assert bool(set(found.free) & set(LIMITS)) is bool(limits)


@given(st.floats(1e-3, 0.02), st.floats(1e3, 1e6), st.floats(0.01, 10.0))
def test_how_unlikely_a_drum_is_grows_with_the_square_near_nominal_and_with_the_logarithm_far_off(near, far, sigma):
    """log(1 + z^2/2) is z^2/2 less its square's half, and log(z^2/2) and at most 2/z^2 more; nothing for no prior."""
    sigmas = np.array([sigma, np.inf])
    close, remote = (float(_improbability(np.array([z * sigma, 1.0]), sigmas)) for z in (near, far))
    assert close == pytest.approx(0.5 * near**2, rel=0.25 * near**2 + 1e-9)
    assert remote == pytest.approx(2.0 * np.log(far) - np.log(2.0), abs=2.0 / far**2 + 1e-9)
    both = _improbability(np.array([near * sigma, far * sigma]), np.array([sigma, sigma]))
    assert float(both) == pytest.approx(close + remote)


def excerpts(excerpt_of, winch, seconds, *, size=0.6, seed=1, noise=0.0, resolution=1e-3, every=20):
    """Yield the record, `every` so many ticks, of a virtual winch with an encoder of a `noise` and `resolution` [m]."""
    rates, random = waves(seconds, size, seed=seed), np.random.default_rng(seed)
    _, states = driven(replace(winch, encoder=replace(winch.encoder, resolution=0.0)), rates)
    read = np.array([s.encoder_payout for s in states]) + noise * random.standard_normal(len(states))
    read = resolution * np.round(read / resolution)
    taken = np.array([s.command_sequence for s in states], dtype=float)
    for end in range(100, len(rates) + 1, every):
        columns = {"order_rate": rates[:end], "sequence": 2.0 + np.arange(end), "taken": taken[:end]}
        yield excerpt_of(end, encoder=read[:end], **columns)


class Looking:
    """A winch's identifier that is asked again and again, what is assumed by then, and all its answers."""

    def __init__(self):
        self.identifier, self.assumed, self.answers = WinchIdentifier(BELIEF, DT), {}, []

    def look(self, excerpt):
        answer = self.identifier.look(excerpt, SensorHistory(), {n: b.value for n, b in self.assumed.items()})
        if answer is not None:
            self.answers.append(answer)
            kept = {n: b for n, b in self.assumed.items() if n not in answer.nominal}
            self.assumed = kept | dict(answer.changed)

    def look_at_last(self, excerpt_of, end, **columns):
        """Look at as much as is used of `columns` up to the tick `end`."""
        begin = max(0, end - round(self.identifier.length / DT))
        self.look(excerpt_of(end - begin, first=begin, **{n: c[begin:end] for n, c in columns.items()}))


def assumed_of(excerpt_of, winch, seconds, **record):
    """Return what is assumed of a winch after so many `seconds`, evaluated each second, and each answer."""
    looking = Looking()
    for excerpt in excerpts(excerpt_of, winch, seconds, **record):
        looking.look(excerpt)
    return looking.assumed, looking.answers


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "resolution"), [(1e-3, 1e-3), (5e-3, 1e-3), (0.0, 5e-3)], ids=["1", "5", "coarse"])
def test_nothing_is_found_of_a_winch_that_is_as_believed(excerpt_of, noise, resolution):
    """Twenty draws, each of 12 s, of an encoder of 1 mm, of one with noise of 5 mm, and of one that counts in 5 mm."""
    found = {}
    for seed in range(20):
        assumed, answers = assumed_of(
            excerpt_of, WinchParameters(), 12.0, seed=seed, noise=noise, resolution=resolution, every=60
        )
        if assumed or any(answer.factor for answer in answers):
            found[seed] = assumed
    assert found == {}


def test_a_millisecond_of_jitter_of_the_delay_hides_no_limit(excerpt_of):
    """0.2 s lies on the edge of a tick: each order comes in one tick or the next."""
    weak = WinchParameters(command_jitter=1e-3, acceleration_limit=0.75, stop_deceleration=0.75)
    assumed, _ = assumed_of(excerpt_of, weak, 30.0, size=0.9)
    for name in ("winch.acceleration_out", "winch.acceleration_in"):
        assert assumed[name].value == pytest.approx(0.75, rel=0.04)
    assert "winch.speed_gain" not in assumed or assumed["winch.speed_gain"].value == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("noise", [0.002, 0.01])
def test_a_limit_is_learnt_with_all_that_is_found_beside_it_whatever_noise_is_left(excerpt_of, noise):
    """A drum of a seventh of its speed: without the limit the gain found beside it would be another drum's."""
    weak = WinchParameters(speed_limit=0.3)
    assumed, _ = assumed_of(excerpt_of, weak, 30.0, size=0.9, noise=noise)
    for name in ("winch.speed_out", "winch.speed_in"):
        assert assumed[name].value == pytest.approx(0.3, rel=0.05)


@pytest.mark.parametrize(("late", "every"), [(1, 97), (1, 140), (6, 97)])
def test_a_machine_that_stalls_now_and_then_is_not_taken_for_a_weak_winch(excerpt_of, late, every):
    """Each `every` ticks the commands of `late` ticks come together with the next, to a winch that is as assumed."""
    rates, virtual = waves(40.0, 0.6), VirtualWinch(WinchParameters(), tick_period=DT)
    virtual.step(0, WinchCommand(1))
    read, taken = np.empty(len(rates)), np.empty(len(rates))
    looking = Looking()
    for k, rate in enumerate(rates):
        stalls = k > late and k % every < late
        state = virtual.step(k + 1, None if stalls else WinchCommand(k + 2, 0.0, float(rate)))
        read[k], taken[k] = state.encoder_payout, state.command_sequence
        if k % 20 == 19 and k > 100:
            columns = {"order_rate": rates, "sequence": 2.0 + np.arange(len(rates)), "taken": taken, "encoder": read}
            looking.look_at_last(excerpt_of, k + 1, **columns)
    assert not looking.assumed
    assert not any(answer.factor for answer in looking.answers)


def test_a_limit_that_waves_do_not_reach_any_more_stays_for_a_minute(excerpt_of):
    weak, looking, held = WinchParameters(speed_limit=0.6), Looking(), []
    rates = np.concatenate([waves(30.0, 0.8), waves(40.0, 0.2)])
    readings, states = driven(weak, rates)
    taken = np.array([s.command_sequence for s in states], dtype=float)
    for end in range(200, len(rates), 20):
        columns = {"order_rate": rates, "sequence": 2.0 + np.arange(len(rates)), "taken": taken, "encoder": readings}
        looking.look_at_last(excerpt_of, end, **columns)
        held.append(looking.assumed["winch.speed_out"].value if "winch.speed_out" in looking.assumed else 2.0)
    assert held[20:] == pytest.approx(len(held[20:]) * [0.6], rel=0.05)


@pytest.mark.parametrize(("still", "is_answered"), [(1.5, True), (2.1, False)])
def test_a_drum_that_has_not_turned_for_two_seconds_is_not_judged(excerpt_of, still, is_answered):
    """It may be its encoder that stands: a slow servo, which is answered as such else, whose readings stand."""
    *_, excerpt = excerpts(excerpt_of, WinchParameters(time_constant=0.4), 15.0)
    count, column = round(still / DT), TICK_COLUMNS.index("encoder")
    ticks = excerpt.ticks.copy()
    ticks[-count:, column] = ticks[-count, column]
    excerpt = replace(excerpt, ticks=ticks)
    answer = WinchIdentifier(BELIEF, DT).look(excerpt, SensorHistory(), {})
    assert (answer is not None) is is_answered


def test_a_still_drum_tells_nothing(excerpt_of):
    assumed, answers = assumed_of(excerpt_of, WinchParameters(time_constant=0.4), 15.0, size=0.0)
    assert not any(answer.factor for answer in answers)
    assert not assumed


def test_a_fit_never_leaves_what_a_drum_can_be():
    found = fit_drum(
        record_of(WinchParameters(speed_gain=0.3)), PRIOR, begun(record_of(WinchParameters()), NOMINAL), (0, 1, 2)
    )
    assert np.all(found.theta[: FACTOR + 1] >= PRIOR.lowest)
    assert np.all(found.theta[: FACTOR + 1] <= PRIOR.highest)
    assert all(price > 0.0 for price in PRICES.values())


def test_a_position_loop_is_part_of_the_drum():
    """Servo with k_p = 0.5 1/s: the virtual winch's own record, from the same set-points."""
    rates = waves(20.0, 0.5)
    encoder, _ = driven(WinchParameters(position_gain=0.5), rates)
    payouts, orders = np.zeros(len(rates) + 10), np.concatenate([np.zeros(10), rates])
    drums = np.array([drum_of(BELIEF.winch)])
    sent = sent_points(payouts, orders, np.zeros(len(orders)), np.zeros(len(orders)))
    drum = drum_records(sent, drums, np.zeros((1, 2)), 0.5, len(rates), DT)[0]
    # the encoder rounds to 1 mm; the position loop's steps of 5 ms differ by less
    np.testing.assert_allclose(drum, encoder, atol=1e-3)


def test_orders_that_came_late_move_the_drum_late():
    """A drum without lag or delay that is sent 1 m/s, the order of tick 10 three ticks late."""
    drums, rates, late, none = np.array([Drum(0.005, 0.0, speed_out=9.0, speed_in=9.0)]), *np.zeros((3, 40))
    rates[10:], late[10:13] = 1.0, [3.0, 2.0, 1.0]
    prompt, delayed = (
        drum_records(sent_points(none, rates, took, none), drums, np.zeros((1, 2)), 0.0, 40, DT)[0]
        for took in (none, late)
    )
    np.testing.assert_allclose(delayed[20:], prompt[17:37], atol=1e-9)
