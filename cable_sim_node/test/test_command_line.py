"""The way of commands to the drive, by itself: when each takes effect, and which come at all."""

import math

import pytest
from cable_sim_node.winch.command_line import CommandLine, WinchCommand, round_to_tick
from cable_sim_node.winch.parameters import WinchParameters
from heave_node.interface.faults import FaultParameters, FaultSchedule

TICK = 0.05


def line(*, delay=0.2, jitter=0.0, seed=1):
    """Return a line and its faults."""
    faults = FaultSchedule(FaultParameters(), name="winch", device="winch")
    parameters = WinchParameters(command_delay=delay, command_jitter=jitter)
    return CommandLine(parameters, faults, tick_period=TICK, seed=seed), faults


def sent(commands, ticks):
    """Send a command in each of the `ticks`; return how many ticks later each takes effect, and the sequence taken."""
    late, taken = [], []
    for sequence, tick in enumerate(ticks, start=1):
        commands.send(tick, WinchCommand(sequence))
        late.append(commands.next_effect - tick)
        taken.append(commands.take(1e9).sequence)
    return late, taken


def test_a_command_takes_effect_after_its_delay_and_is_taken_once():
    commands, _ = line(delay=0.23)
    assert commands.next_effect == math.inf
    assert commands.take(1e9) is None
    commands.send(7, WinchCommand(1))
    commands.send(8, WinchCommand(2))
    assert commands.next_effect == pytest.approx(7.0 + 0.23 / TICK)
    assert commands.take(commands.next_effect - 0.01) is None
    assert commands.take(commands.next_effect) == WinchCommand(1)
    assert commands.next_effect == pytest.approx(8.0 + 0.23 / TICK)
    assert [commands.take(100.0), commands.take(100.0)] == [WinchCommand(2), None]


def test_the_same_command_again_is_none_and_another_of_the_same_number_is_one():
    commands, _ = line()
    for command in (WinchCommand(1), None, WinchCommand(1), WinchCommand(1, 0.5)):
        commands.send(0, command)
    assert [commands.take(100.0) for _ in range(3)] == [WinchCommand(1), WinchCommand(1, 0.5), None]


def test_jitter_spreads_a_command_evenly_about_its_delay():
    """0.2 s and up to 0.1 s more or less are 2 to 6 ticks; one alone is not held up by the one before."""
    commands, _ = line(jitter=0.1)
    late, _ = sent(commands, range(0, 20_000, 10))
    assert 2.0 <= min(late) < 2.02
    assert 5.98 < max(late) <= 6.0
    assert sum(late) / len(late) == pytest.approx(4.0, abs=0.1)


def test_jitter_keeps_the_order_of_commands_and_lets_none_act_before_it_was_sent():
    """1 s of jitter are twenty ticks: a command would overtake those before it, or act in the past."""
    commands, _ = line(delay=0.1, jitter=1.0)
    for tick in range(200):
        commands.send(tick, WinchCommand(tick + 1))
    effects, sequences = [], []
    while commands.next_effect < math.inf:
        effects.append(commands.next_effect)
        sequences.append(commands.take(1e9).sequence)
    assert sequences == list(range(1, 201))
    assert effects == sorted(effects)
    assert all(effect >= tick for tick, effect in enumerate(effects))
    alone, _ = sent(line(delay=0.1, jitter=1.0)[0], range(0, 20_000, 50))
    assert min(alone) == 0.0


def test_the_jitter_is_that_of_its_seed():
    draws = [sent(line(jitter=0.1, seed=seed)[0], range(0, 1000, 10))[0] for seed in (1, 1, 2)]
    assert draws[0] == draws[1] != draws[2]


def test_a_cut_line_loses_commands_and_a_slow_one_holds_them_back_so_that_later_ones_overtake():
    commands, faults = line()
    faults.inject("gap", start=1.0, duration=0.5)
    faults.inject("delay", start=2.0, duration=0.5, magnitude=1.0)
    for tick in (10, 25, 45, 55):
        commands.send(tick, WinchCommand(tick))
    effects, sequences = [], []
    while commands.next_effect < math.inf:
        effects.append(commands.next_effect)
        sequences.append(commands.take(1e9).sequence)
    assert sequences == [10, 55, 45]
    assert effects == pytest.approx([14.0, 59.0, 69.0])


def test_a_fault_of_jitter_holds_each_command_back_by_its_own_time():
    commands, faults = line()
    faults.inject("jitter", start=0.0, magnitude=0.4)
    lates, _ = sent(commands, range(0, 1000, 20))
    assert len(set(lates)) > 40
    assert all(0.2 <= late * TICK <= 0.6 for late in lates)


@pytest.mark.parametrize(
    ("time", "rounded"), [(3.0 + 1e-7, 3.0), (3.0 - 1e-7, 3.0), (3.00001, 3.00001), (2.99999, 2.99999), (0.5, 0.5)]
)
def test_a_time_at_a_tick_but_for_rounding_is_at_it(time, rounded):
    assert round_to_tick(time) == rounded


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_command_is_finite_where_both_its_set_points_are(bad):
    assert WinchCommand(1).is_finite()
    assert not WinchCommand(1, payout=bad).is_finite()
    assert not WinchCommand(1, payout_rate=bad).is_finite()
    assert WinchCommand(1) == WinchCommand(1, 0.0, 0.0, brake=False)
