"""Orders against the encoder over the last seconds: how far the drum is off, and what the encoder reads of them."""

import dataclasses

import numpy as np
import pytest
from cable_sim_node.winch.component import VirtualWinch, WinchCommand
from cable_sim_node.winch.parameters import WinchParameters
from heave_core.watch_table import ReflexNews
from winch_controller_node.core.supervision.watch.drum_watch import CHECKED_TIME, ORDERED_TIME, DrumWatch
from winch_controller_node.core.supervision.watch.encoder_reflex import CONSTANTS, EncoderReflex
from winch_controller_node.node_parameters import WinchControllerParameters

from tests.core_parts import Ordered, drum_error, drum_ordered, look_at_encoder, reads

DT = 0.05
BELIEF = WinchControllerParameters()


def waves(seconds, size=0.5):
    time = DT * np.arange(round(seconds / DT))
    return size * (np.sin(0.7 * time) + 0.5 * np.sin(1.1 * time))


def watched(*, seconds=20.0, factor=1.0, believed=None, size=0.5, gap=(), limited=(), **winch):
    """Return the watch of a winch whose encoder reads `factor` times the payout, its errors, and the payouts.

    There is no reading in the ticks of the `gap`; a limit acts in those that are `limited`.
    """
    watch, drum = (
        DrumWatch(BELIEF.winch, BELIEF.lag.largest, DT),
        VirtualWinch(WinchParameters(**{"supervision_time": 0.0, **winch}), tick_period=DT),
    )
    watch.take(believed or {})
    watch.reset()
    drum.step(0, WinchCommand(1))
    errors, payouts = [], []
    for tick, rate in enumerate(waves(seconds, size), start=1):
        state = drum.step(tick, WinchCommand(tick + 1, 0.0, float(rate)))
        read = None if tick in gap else factor * state.encoder_payout
        watch.add(0.0, float(rate), read, is_limited=tick in limited)
        errors.append(drum_error(watch))
        payouts.append(state.payout)
    return watch, np.array(errors), np.array(payouts)


def test_a_drum_as_believed_is_where_it_was_predicted():
    """Readings in millimetres: what a second of them predicts for the next is some millimetres at the most."""
    _, errors, _ = watched()
    assert np.max(np.abs(errors)) < 4e-3


@pytest.mark.parametrize("winch", [{"speed_gain": 0.8}, {"time_constant": 0.5}, {"speed_limit": 0.4}], ids=str)
def test_a_winch_other_than_believed_is_missed_until_it_is_believed(winch):
    quantities = {"speed_gain": ["winch.speed_gain"], "time_constant": ["winch.time_constant"]}
    quantities["speed_limit"] = ["winch.speed_out", "winch.speed_in"]
    ((name, value),) = winch.items()
    assert np.max(np.abs(watched(**winch)[1])) > 0.04
    known = watched(believed=dict.fromkeys(quantities[name], value), **winch)[1]
    assert np.max(np.abs(known)) < 6e-3


def test_nothing_is_predicted_from_too_few_readings_or_through_a_gap():
    count = 2 * round(CHECKED_TIME / DT)
    _, errors, _ = watched(speed_gain=0.5, gap=[200])
    assert not np.any(errors[: count - 1])
    assert not np.any(errors[199 : 199 + count])
    assert errors[199 + count] != 0.0


def test_a_restart_forgets_the_readings_and_a_reset_the_orders_as_well():
    watch, *_ = watched(speed_gain=0.5)
    assert drum_error(watch) != 0.0
    watch.restart()
    assert (drum_error(watch), drum_ordered(watch)) == (0.0, None)
    watch.reset(2.0)
    for _ in range(3 * round(CHECKED_TIME / DT)):
        watch.add(2.0, 0.0, 2.0)
    assert drum_error(watch) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("factor", "gain"),
    [(1.0, 1.0), (0.5, 1.0), (-1.0, 1.0), (2.0, 1.0), (0.8, 1.0), (1.0, 0.8), (1.0, 1.3), (0.5, 1.3)],
)
def test_an_encoder_reads_its_factor_times_the_gain_of_the_winch_of_what_that_was_ordered(factor, gain):
    """The speed at the start is known to a tick: 0.02 m/s for the lag of 0.15 s are 3 mm, of 3 cm and more."""
    watch, _, payouts = watched(factor=factor, speed_gain=gain)
    ordered, count = drum_ordered(watch), round(ORDERED_TIME / DT)
    assert ordered.share == pytest.approx(factor * gain, rel=0.06)
    assert ordered.left < 0.15
    travel = (payouts[-1] - payouts[-1 - count]) / gain
    assert ordered.payout == pytest.approx(factor * payouts[-1 - count] + travel, abs=0.02)


def test_a_gain_that_is_believed_is_none_of_the_encoder():
    ordered = drum_ordered(watched(speed_gain=0.7, believed={"winch.speed_gain": 0.7})[0])
    assert ordered.share == pytest.approx(1.0, rel=0.05)
    assert reads(EncoderReflex(DT), ordered, "true")


@pytest.mark.parametrize(
    "case", [{"size": 0.002}, {"gap": range(390, 398)}, {"gap": [400 - 16]}, {"seconds": 0.5}], ids=str
)
def test_too_little_that_was_read_or_moved_tells_nothing_of_the_encoder(case):
    assert drum_ordered(watched(**case)[0]) is None


@pytest.mark.parametrize(
    ("limited", "is_limited"), [((400,), True), ((386,), True), ((380,), False), ((), False)], ids=str
)
def test_a_limit_counts_where_it_acted_while_orders_and_encoder_are_compared(limited, is_limited):
    """Of 400 ticks the last 0.8 s, which are 16."""
    assert drum_ordered(watched(limited=limited)[0]).is_limited is is_limited


COUNT = round(ORDERED_TIME / DT)


def test_a_new_watch_needs_no_reset_and_takes_the_winch_for_the_nominal_one_at_rest():
    watch, drum = DrumWatch(BELIEF.winch, BELIEF.lag.largest, DT), VirtualWinch(WinchParameters(), tick_period=DT)
    drum.step(0, WinchCommand(1))
    for tick, rate in enumerate(waves(2.2), start=1):
        watch.add(0.0, float(rate), drum.step(tick, WinchCommand(tick + 1, 0.0, float(rate))).encoder_payout)
        assert abs(drum_error(watch)) < 4e-3
    assert drum_ordered(watch).share == pytest.approx(1.0, rel=0.05)


@pytest.mark.parametrize(("missing", "is_known"), [(4, True), (5, False)])
def test_four_fifths_of_the_readings_are_enough(missing, is_known):
    """Of 16 ticks 12.8 need readings: of the 17 readings four may be missing."""
    assert (drum_ordered(watched(gap=range(390, 390 + missing))[0]) is not None) is is_known


@pytest.mark.parametrize(("speed", "is_known"), [(0.02, True), (0.016, False)])
def test_a_few_millimetres_of_motion_are_needed(speed, is_known):
    """A steady speed v over sixteen ticks: 1 sigma is v * DT * sqrt((16^2 - 1) / 12), 4.6 and 3.7 mm, of which 4."""
    watch = DrumWatch(BELIEF.winch, BELIEF.lag.largest, DT)
    for tick in range(200):
        watch.add(0.0, speed, speed * DT * tick)
    ordered = drum_ordered(watch)
    assert (ordered is not None) is is_known
    if ordered is not None:
        assert (ordered.share, ordered.left) == pytest.approx((1.0, 0.0), abs=1e-3)
        assert not ordered.is_limited


@pytest.mark.parametrize("started", [280, 330])
def test_after_a_restart_in_motion_the_speed_that_a_slow_servo_had_by_then_counts(started):
    """T = 1.5 s: after 3.5 and 6 s its first speed still shows, which was ordered a lag and a delay before."""
    slow = {"time_constant": 1.5, "supervision_time": 0.0}
    watch, drum = DrumWatch(BELIEF.winch, BELIEF.lag.largest, DT), VirtualWinch(WinchParameters(**slow), tick_period=DT)
    watch.take({"winch.time_constant": 1.5})
    drum.step(0, WinchCommand(1))
    for tick, rate in enumerate(waves(20.0), start=1):
        state = drum.step(tick, WinchCommand(tick + 1, 0.0, float(rate)))
        watch.add(0.0, float(rate), state.encoder_payout)
        if tick == started:
            watch.restart()
    ordered = drum_ordered(watch)
    assert ordered.share == pytest.approx(1.0, rel=0.1)
    assert ordered.left < 0.15


def looped(*, gain=0.5, gap=(), place=0.0, seconds=6.0, reset=None):
    """Return the watch of a winch with a position loop that starts at rest at `place`, and its errors."""
    belief = dataclasses.replace(BELIEF.winch, position_gain=gain)
    watch = DrumWatch(belief, BELIEF.lag.largest, DT)
    drum = VirtualWinch(WinchParameters(position_gain=gain), tick_period=DT)
    watch.reset(place if reset is None else reset)
    drum.step(0, WinchCommand(1))
    errors = []
    for tick, rate in enumerate(waves(seconds, 0.2), start=1):
        state = drum.step(tick, WinchCommand(tick + 1, 0.0, float(rate)))
        watch.add(place, float(rate), None if tick in gap else place + state.encoder_payout)
        errors.append(drum_error(watch))
    return watch, np.array(errors)


@pytest.mark.parametrize(("gap", "off"), [((), 0.06), ((89,), 0.4)], ids=["all read", "the first one missing"])
def test_a_position_loop_is_predicted_from_where_the_drum_was(gap, off):
    """Of 120 ticks the last 16, and five time constants, 15 ticks, before them: from the reading of tick 89 on.

    Without that one it is taken to have begun where it was read 15 ticks later: the loop then goes for another place.
    """
    for place in (0.0, 3.0):
        watch, errors = looped(gap=gap, place=place)
        ordered = drum_ordered(watch)
        assert ordered.share == pytest.approx(1.0, rel=off)
        assert ordered.left < 0.05
        if not gap:
            assert np.max(np.abs(errors)) < 6e-3


def test_the_orders_before_a_reset_were_to_stay_where_the_drum_was():
    """Had they been orders to 0 m for the longest delay, the loop would have moved a drum at 3 m by half a metre."""
    late = {"winch.command_delay": BELIEF.winch.command_delay + BELIEF.lag.largest}
    watch = DrumWatch(dataclasses.replace(BELIEF.winch, position_gain=0.5), BELIEF.lag.largest, DT)
    watch.take(late)
    for _ in range(50):
        watch.add(0.0, 0.5, 0.0, tension=1e4)
    watch.reset(3.0)
    for _ in range(2 * round(CHECKED_TIME / DT)):
        watch.add(3.0, 0.0, 3.0)
    assert drum_error(watch) == pytest.approx(0.0, abs=1e-9)


LONGEST_DELAY = BELIEF.winch.command_delay + BELIEF.lag.largest


def test_a_new_watch_takes_the_orders_before_it_for_orders_to_stay_at_zero():
    watch = DrumWatch(dataclasses.replace(BELIEF.winch, position_gain=0.5), BELIEF.lag.largest, DT)
    watch.take({"winch.command_delay": LONGEST_DELAY})
    for _ in range(2 * round(CHECKED_TIME / DT)):
        watch.add(0.0, 0.0, 0.0)
    assert drum_error(watch) == pytest.approx(0.0, abs=1e-9)


def stepped(ticks, *, began=0, delay=LONGEST_DELAY, gain=0.0, restarted=None, reset=None):
    """Return what is known of a drum that is ordered to and fro by steps, and where the drum is at the end.

    Orders go the other way every fifteen ticks from tick `began` on. The watch is restarted or reset in a tick.
    """
    watch = DrumWatch(dataclasses.replace(BELIEF.winch, position_gain=gain), BELIEF.lag.largest, DT)
    drum = VirtualWinch(WinchParameters(command_delay=delay, position_gain=gain), tick_period=DT)
    watch.take({"winch.command_delay": delay})
    drum.step(0, WinchCommand(1))
    for tick in range(1, ticks + 1):
        rate = 0.0 if tick < began else 0.4 if (tick - began) % 30 < 15 else -0.4
        state = drum.step(tick, WinchCommand(tick + 1, 0.0, rate))
        if tick == restarted:
            watch.restart()
        if tick == reset:
            watch.reset(state.payout)
        watch.add(0.0, rate, state.encoder_payout)
    return drum_ordered(watch), state.payout


@pytest.mark.parametrize("restarted", [66, 68, 69])
@pytest.mark.parametrize("more", [0, 1])
def test_right_after_a_restart_the_orders_that_were_under_way_count_and_the_drum_is_where_it_reads(restarted, more):
    """Sixteen ticks, of which the longest delay, ten ticks, is of orders before: steps at 60 and 75, at 70 and 85."""
    ordered, payout = stepped(restarted + COUNT + more, restarted=restarted)
    assert ordered.share == pytest.approx(1.0, rel=0.05)
    assert ordered.left < 0.15
    assert ordered.payout == pytest.approx(payout, abs=0.02)


def test_a_reset_watch_knows_that_no_order_was_under_way():
    """Of sixteen ticks the first ten are at rest: had orders been under way, the drum would have moved at once."""
    ordered, payout = stepped(100 + COUNT, began=100, reset=100)
    assert ordered.share == pytest.approx(1.0, rel=0.01)
    assert ordered.payout == pytest.approx(payout, abs=1e-3)


def test_a_position_loop_goes_from_where_the_drum_was_first_read_after_a_restart_in_motion():
    ordered, payout = stepped(60 + COUNT, delay=BELIEF.winch.command_delay, gain=2.0, restarted=60)
    assert ordered.share == pytest.approx(1.0, rel=0.02)
    assert ordered.payout == pytest.approx(payout, abs=5e-3)


@pytest.mark.parametrize(("rate", "read"), [(0.5, 0.0), (0.0, 0.5)], ids=["encoder", "winch"])
def test_where_either_encoder_or_orders_stand_still_nothing_is_known_of_their_ratio(rate, read):
    watch = DrumWatch(BELIEF.winch, BELIEF.lag.largest, DT)
    for tick in range(200):
        watch.add(0.0, rate, read * DT * tick)
    assert drum_ordered(watch) is None


@pytest.mark.parametrize("gain", [1.3, 0.7])
def test_a_drum_that_goes_on_faster_than_ordered_is_ahead_by_what_a_second_of_readings_did_not_show(gain):
    """0.2 m/s ordered. Place and speed at the start, which a lag of 0.15 s takes back, explain the first second."""
    watch = DrumWatch(BELIEF.winch, BELIEF.lag.largest, DT)
    for tick in range(80):
        watch.add(0.0, 0.2, gain * 0.2 * DT * tick)
    time = DT * np.arange(40)
    unexplained = (gain - 1.0) * 0.2 * time
    columns = np.stack([np.ones(40), 1.0 - np.exp(-time / 0.15)], axis=1)
    best = np.linalg.lstsq(columns[:20], unexplained[:20], rcond=None)[0]
    assert drum_error(watch) == pytest.approx((unexplained - columns @ best)[-1], rel=0.06)


def test_a_limited_drum_goes_by_the_tension_of_each_tick_from_the_first_one_on():
    """50 kW: 0.25 m/s at 200 kN, 0.125 at 400 kN, to which it changes with the second second."""
    watch = DrumWatch(BELIEF.winch, BELIEF.lag.largest, DT)
    watch.take({"winch.power_limit": 50e3})
    payout = 0.0
    for tick in range(40):
        speed, tension = (0.25, 200e3) if tick < 20 else (0.125, 400e3)
        payout += speed * DT
        watch.add(0.0, 0.6, payout, tension=tension)
    assert drum_error(watch) == pytest.approx(0.0, abs=0.04)


def test_orders_that_act_only_after_the_longest_delay_are_all_at_hand():
    """To and fro by steps of 0.4 m/s: an order that is lost before it acts leaves the drum where it was not."""
    longest = BELIEF.winch.command_delay + BELIEF.lag.largest
    watch = DrumWatch(BELIEF.winch, BELIEF.lag.largest, DT)
    drum = VirtualWinch(WinchParameters(command_delay=longest), tick_period=DT)
    watch.take({"winch.command_delay": longest})
    drum.step(0, WinchCommand(1))
    errors = []
    for tick in range(1, 200):
        rate = 0.4 if tick % 30 < 15 else -0.4
        state = drum.step(tick, WinchCommand(tick + 1, 0.0, rate))
        watch.add(0.0, rate, state.encoder_payout)
        errors.append(drum_error(watch))
    assert np.max(np.abs(errors)) < 6e-3


def test_a_drum_whose_power_is_limited_is_predicted_under_the_tension_that_was_told():
    """50 kW at 200 kN are 0.25 m/s. Of an unknown tension nothing is predicted: it would have gone at 0.6 m/s."""
    for told, is_predicted in ((200e3, True), (np.nan, False)):
        watch = DrumWatch(BELIEF.winch, BELIEF.lag.largest, DT)
        watch.take({"winch.power_limit": 50e3})
        for tick in range(200):
            watch.add(0.0, 0.6, 0.25 * DT * tick, tension=told)
        ordered = drum_ordered(watch)
        assert (ordered.share == pytest.approx(1.0, abs=0.01)) is is_predicted


@pytest.mark.parametrize(
    ("share", "left", "said"),
    [
        (-0.21, 0.14, "reversed sudden"),
        (-0.19, 0.14, "sudden"),
        (-0.21, 0.16, ""),
        (-0.21, 0.15, ""),
        (-0.2, 0.14, "sudden"),
        (1.0, 0.15, ""),
        (1.7, 0.15, ""),
        (0.5, 0.14, "sudden"),
        (0.59, 0.14, "sudden right"),
        (0.61, 0.14, "right"),
        (0.89, 0.14, "right"),
        (0.91, 0.14, "right true"),
        (1.09, 0.14, "right true"),
        (1.09, 0.16, ""),
        (1.11, 0.14, "right"),
        (1.59, 0.14, "right"),
        (1.61, 0.14, "sudden right"),
        (1.61, 0.16, ""),
        (0.49, 0.14, "sudden"),
        (0.51, 0.14, "sudden right"),
    ],
)
def test_what_is_said_of_an_encoder_begins_at_these_ratios(share, left, said):
    """Wrong by three fifths in less or more, by a tenth no more true; beyond the rest of 0.15 nothing is said."""
    one, reflex = Ordered(share, left, 0.0), EncoderReflex(DT)
    named = {
        "reversed": reads(reflex, one, "reversed", False),
        "sudden": reads(reflex, one, "suddenly", False),
        "right": reads(reflex, one, "the_right_way"),
        "true": reads(reflex, one, "true"),
    }
    assert {name for name, is_so in named.items() if is_so} == set(said.split())


@pytest.mark.parametrize(
    ("share", "is_reversed", "is_sudden"),
    [
        (0.49, True, True),
        (0.5, False, True),
        (0.75, False, True),
        (1.3, False, True),
        (0.51, False, True),
        (0.74, False, True),
        (0.76, False, False),
        (1.29, False, False),
        (1.31, False, True),
    ],
)
@pytest.mark.parametrize("left", [0.0, 0.9])
def test_what_was_said_of_an_encoder_ends_later_whatever_is_left(share, left, is_reversed, is_sudden):
    one, reflex = Ordered(share, left, 0.0, is_limited=True), EncoderReflex(DT)
    assert reads(reflex, one, "reversed", True) is is_reversed
    assert reads(reflex, one, "suddenly", True) is is_sudden


# the reflex

BEGINNING, LONGEST_ASIDE, LOOKS = (CONSTANTS[name] for name in ("beginning", "longest_aside", "looks"))
NOTHING, SET_ASIDE, USE_AGAIN = 0, ReflexNews.ENCODER_REFUTED, ReflexNews.ENCODER_TRUSTED
TRUE, HALF, BACK = Ordered(1.0, 0.02, 3.0), Ordered(0.5, 0.02, 3.0), Ordered(-1.0, 0.02, 3.0)
LOOK = 2
"""Ticks from one look to the next: ten looks a second."""


def acts(shown, *, is_aside=False, reflex=None, start=0):
    """Show what was ordered at each look, of a winch that moves without a pause; return acts with their looks."""
    reflex, found = reflex or EncoderReflex(DT), []
    for place, ordered in enumerate(shown):
        for tick in range(start + place * LOOK, start + (place + 1) * LOOK):
            act = look_at_encoder(reflex, tick, ordered, is_aside=is_aside)
            if act:
                found.append((place, act))
                is_aside = act == SET_ASIDE
    return found, reflex


def seconds(time):
    return round(10.0 * time)


def test_before_the_first_look_nothing_is_unresolved():
    reflex = EncoderReflex(DT)
    assert (reflex.is_unresolved, reflex.inhibition) == (False, None)
    assert look_at_encoder(reflex, 0, None, is_aside=False) == NOTHING
    assert not reflex.is_unresolved


def test_an_encoder_that_was_wrong_from_the_start_is_set_aside_at_once_and_nothing_can_be_done():
    """Winch or encoder: which of them is turned over nobody knows."""
    found, reflex = acts([BACK] * 3)
    assert found == [(0, SET_ASIDE)]
    assert reflex.is_unresolved
    assert reflex.inhibition.name == "DRUM_OR_ENCODER: unresolved reversal"


def test_one_that_turns_over_later_is_set_aside_after_so_many_looks_and_the_loop_goes_on():
    found, reflex = acts([TRUE] * seconds(BEGINNING) + [BACK] * 5)
    assert found == [(seconds(BEGINNING) + LOOKS - 1, SET_ASIDE)]
    assert not reflex.is_unresolved
    assert reflex.inhibition is None


def test_a_look_that_is_wrong_once_is_none():
    assert acts(([TRUE] * 20 + [BACK]) * 10)[0] == []


def test_a_scale_is_sudden_only_where_the_winch_is_known():
    """A winch of half its gain from the start is the adviser's to find."""
    assert acts([HALF] * 300)[0] == []
    found, _ = acts([TRUE] * seconds(40.0) + [HALF] * 5)
    assert [act for _, act in found] == [SET_ASIDE]


def test_no_limit_makes_a_drum_go_further_than_it_was_ordered():
    """An encoder that reads twice as much all at once is at fault, whether or not orders hit a limit meanwhile."""
    twice = Ordered(2.0, 0.02, 3.0, is_limited=True)
    found, _ = acts([TRUE] * seconds(40.0) + [twice] * 5)
    assert found == [(seconds(40.0) + LOOKS - 1, SET_ASIDE)]


def test_a_scale_is_not_sudden_while_a_limit_acts():
    """A drum at a limit does less than it was ordered; one that turns the other way has no such allowance."""
    half, back = (one._replace(is_limited=True) for one in (HALF, BACK))
    assert acts([TRUE] * seconds(40.0) + [half] * 50)[0] == []
    # the winch is known for 10 log(0.98 / 0.8) = 2 s more
    found, _ = acts([TRUE] * seconds(40.0) + [half] * seconds(1.0) + [HALF] * 5)
    assert [act for _, act in found] == [SET_ASIDE]
    assert [act for _, act in acts([TRUE] * seconds(40.0) + [back] * 5)[0]] == [SET_ASIDE]
    # one that is set aside already is not used again for that
    assert reads(EncoderReflex(DT), half, "suddenly", True)


def test_a_winch_that_has_not_done_what_it_was_ordered_for_long_is_not_known_any_more():
    """Ten seconds without a true look leave exp(-1) of the share: what the encoder then reads may be the winch."""
    limited = HALF._replace(is_limited=True)
    assert acts([TRUE] * seconds(40.0) + [limited] * seconds(10.0) + [HALF] * 5)[0] == []


def test_the_second_look_that_is_wrong_sets_an_encoder_aside():
    """It has gone the right way, be it for two seconds: the sign was not wrong from the start."""
    found, reflex = acts([TRUE] * 20 + [BACK] * 5)
    assert found == [(21, SET_ASIDE)]
    assert not reflex.is_unresolved


def test_one_that_goes_right_again_is_used_again():
    found, reflex = acts([TRUE] * 200 + [BACK] * 10 + [TRUE] * 10)
    assert [act for _, act in found] == [SET_ASIDE, USE_AGAIN]
    assert not reflex.is_unresolved


def test_one_that_stays_aside_for_long_is_unresolved_until_an_operator_asks():
    found, reflex = acts([TRUE] * 200 + [BACK] * (seconds(LONGEST_ASIDE) + 5))
    assert [act for _, act in found] == [SET_ASIDE]
    assert reflex.is_unresolved
    reflex.restart()
    assert not reflex.is_unresolved


def test_after_a_restart_time_and_looks_begin_anew():
    aside = seconds(LONGEST_ASIDE) - 1
    _, reflex = acts([TRUE] * 200 + [BACK] * LOOKS)
    acts([BACK] * aside, is_aside=True, reflex=reflex, start=1_000)
    reflex.restart()
    acts([BACK] * aside, is_aside=True, reflex=reflex, start=2_000)
    assert not reflex.is_unresolved
    look_at_encoder(reflex, 4_000, BACK, is_aside=True)
    look_at_encoder(reflex, 4_001, BACK, is_aside=True)
    assert reflex.is_unresolved
    _, once = acts([TRUE] * 200 + [BACK])
    once.restart()
    assert acts([BACK], reflex=once, start=1_000)[0] == []


def test_a_rest_that_is_not_straight_is_no_reason():
    """A drum at its limit lags behind: no multiple of what was ordered explains what it reads."""
    assert acts([Ordered(-1.0, 0.4, 3.0)] * 50)[0] == []
    assert acts([None] * 50)[0] == []


@pytest.mark.parametrize(("moved", "is_unresolved"), [(14.9, True), (15.1, False)])
def test_the_time_in_which_the_winch_moves_counts_from_its_first_tick(moved, is_unresolved):
    """In the first 15 s an encoder may have been wrong from the start."""
    found, reflex = acts([None] * seconds(moved) + [BACK] * 3)
    assert [act for _, act in found] == [SET_ASIDE]
    assert reflex.is_unresolved is is_unresolved


def test_the_time_in_which_the_winch_moves_begins_anew_after_a_pause():
    _, reflex = acts([None] * seconds(BEGINNING + 1.0))
    found, reflex = acts([BACK] * 3, reflex=reflex, start=10_000)
    assert [act for _, act in found] == [SET_ASIDE]
    assert reflex.is_unresolved


def test_it_looks_ten_times_a_second_and_at_nothing_in_between():
    reflex = EncoderReflex(DT)
    assert look_at_encoder(reflex, LOOK + 1, BACK, is_aside=False) == NOTHING
    assert look_at_encoder(reflex, 2 * LOOK, BACK, is_aside=False) == SET_ASIDE
    assert look_at_encoder(EncoderReflex(0.25), 1, BACK, is_aside=False) == SET_ASIDE, "a tick that is longer"


@pytest.mark.parametrize(
    ("shown", "alarm", "inhibition"),
    [
        ([BACK] * 3, "reversed", "unresolved reversal"),
        ([TRUE] * 400 + [HALF] * (seconds(LONGEST_ASIDE) + 5), "scale", "unresolved scale"),
    ],
    ids=["reversed", "scale"],
)
def test_what_is_wrong_with_an_encoder_is_told_by_its_code(shown, alarm, inhibition):
    _, reflex = acts(shown)
    assert reflex.alarm.name == f"DRUM_OR_ENCODER: {alarm}"
    assert reflex.inhibition.name == f"DRUM_OR_ENCODER: {inhibition}"
