"""The running statistics on which the guard rests, by sums and solutions that are exact."""

import math

import pytest
from heave_core.look import RunningSigma
from heave_core.look_table import Harm
from winch_controller_node.core.estimation.sense_design import largest_step
from winch_controller_node.core.supervision.guard_checks import SLOW_MEAN_FACTOR, GuardedLoop, guard_design
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.parameters.laws import GuardParameters

from tests.supervised import Guard, Seen

DT = 0.5
UNLIMITED = WinchLimits(1e9, 1e9, -50.0, 50.0)


def a_guard(**limit):
    """Return a guard whose window is 20 s; `limit` is that of its check of the drum."""
    design = guard_design(GuardParameters(window=20.0), GuardedLoop(UNLIMITED), DT)
    return Guard(design | {"drum": {"time": 2.0, "ratio": 1.5, "floor": 0.0} | limit})


def test_a_time_that_was_set_runs_out_once():
    """The allowance of 30 s of a resumption, in ticks of 0.5 s."""
    guard = a_guard()
    left = []
    for _ in range(2):
        guard.allow_resumption()
        for _ in range(61):
            guard.step(Seen(), 0.0, 1.0, inhibits=False)
            left.append(float(guard.state["allowance"][0]))
    assert left == [*(29.5 - DT * k for k in range(60)), 0.0] * 2


def test_the_first_values_weigh_as_in_a_plain_average():
    """Of 0 and 2 the mean is 1, and the second is off it by 1, the first was by 0; the third is at the mean."""
    sigma = RunningSigma(1e3, DT, SLOW_MEAN_FACTOR)
    found = []
    for value in (0.0, 2.0, 1.0):
        sigma.add(value)
        found.append(sigma.sigma**2)
    assert found == pytest.approx([0.0, 1.0 / 2.0, 1.0 / 3.0])


def heaves(readings, noise=0.0):
    """Return the heave after each of the `readings` of a depth sensor [m]; None: none came."""
    guard, found = a_guard(), []
    for reading in readings:
        guard.step(Seen(measured=math.nan if reading is None else reading, noise=noise), 0.0, 1.0, inhibits=False)
        found.append(float(guard.state["measured"]["value"][0]))
    return found


def test_heave_is_the_sum_of_the_steps_of_which_a_tenth_is_lost_in_half_a_second():
    found = heaves((300.0, 300.25, None, 300.25, 300.0))
    assert found == pytest.approx([0.0, 0.25, 0.225, 0.2025, 0.18225 - 0.25])


@pytest.mark.parametrize("missed", [0, 3])
@pytest.mark.parametrize("noise", [0.0, 0.5])
def test_a_step_that_no_unit_can_have_made_since_the_last_reading_is_none_and_one_up_to_it_is(missed, noise):
    most = largest_step(noise, (missed + 1) * DT)
    for step, is_motion in ((most, True), (-most, True), (most + 2**-10, False)):
        found = heaves([0.0, 0.0, *[None] * missed, step, step + 0.125], noise)
        assert found[-2] == (step if is_motion else 0.0)
        assert found[-1] == pytest.approx(0.9 * (step if is_motion else 0.0) + 0.125), "it goes on from there"


class Checked:
    """The check of a drum, with a memory of 2 s and of 20 s for waves, after spells of (ticks, square, reference)."""

    def __init__(self, *spells, **limit):
        self.guard = a_guard(**limit)
        self.guard.state["authority"] = 1.0
        for ticks, square, reference in spells:
            for _ in range(ticks):
                self.add(square, reference)

    def add(self, square, reference):
        """Let the drum err from a boom tip of that mean square by the square."""
        tip = math.sqrt(reference)
        given = Seen(tip_rate=tip, payout_rate=tip + math.sqrt(square))
        self.verdict = self.guard.step(given, 1.0, 1.0, inhibits=False)

    def again(self, **state):
        """Return what is found with another `state` of the check, after a tick that changes nothing else."""
        for name, value in state.items():
            self.guard.state["drum"][name] = value
        self.add(float(self.guard.state["drum"]["square"][0]), float(self.guard.state["drum"]["now"][0]))
        return self

    @property
    def reference(self):
        return float(max(self.guard.state["drum"]["now"][0], self.guard.state["drum"]["waves"][0]))

    @property
    def amplitude(self):
        return self.verdict.drum

    @property
    def is_exceeded(self):
        return Harm.DRUM_OFF in Harm(int(self.verdict.bits))


def test_an_amplitude_is_that_of_the_last_seconds_and_at_first_of_all_that_was_seen():
    assert Checked((1, 1.0, 0.0), (1, 3.0, 0.0)).amplitude == pytest.approx(math.sqrt(2.0))
    # a quarter of a difference is made up in a tick of 0.5 s of a memory of 2 s
    assert Checked((100, 0.0, 0.0), (2, 16.0, 0.0)).amplitude ** 2 == pytest.approx(16.0 * (1.0 - 0.75**2))


def test_the_reference_is_the_larger_of_now_and_of_the_last_waves():
    assert Checked((1, 0.0, 1.0), (1, 0.0, 3.0)).reference == pytest.approx(2.0)
    assert Checked((2000, 0.0, 0.0), (4, 0.0, 16.0)).reference == pytest.approx(16.0 * (1.0 - 0.75**4))
    assert Checked((2000, 0.0, 16.0), (4, 0.0, 0.0)).reference == pytest.approx(16.0 * (1.0 - 0.025) ** 4)


def test_nothing_is_too_large_before_half_the_time_of_the_waves_was_seen():
    assert not Checked((19, 9.0, 1.0)).is_exceeded
    assert Checked((20, 9.0, 1.0)).is_exceeded


@pytest.mark.parametrize(("square", "is_exceeded"), [(2.25, False), (2.3, True)])
def test_an_amplitude_is_too_large_beyond_its_ratio_to_the_reference(square, is_exceeded):
    assert Checked((50, square, 1.0)).is_exceeded is is_exceeded
    assert not Checked((50, square, 1.0), floor=2.0).is_exceeded, "never below its floor"
    assert Checked((50, 4.0 * square, 0.0), floor=3.0).is_exceeded is is_exceeded


@pytest.mark.parametrize(("left_over", "is_exceeded"), [(0.9, True), (1.1, False)])
def test_what_is_left_over_counts_as_the_reference_does(left_over, is_exceeded):
    """Of 3 m, where 1.5 times 1 m and what is left over are allowed."""
    assert Checked((50, 9.0, 1.0)).again(left_over=left_over).is_exceeded is is_exceeded


def test_noise_that_is_known_is_no_amplitude_and_there_is_none_below_it():
    assert Checked((50, 25.0, 0.0)).again(noise=3.0).amplitude == pytest.approx(4.0)
    assert Checked((50, 25.0, 0.0)).again(noise=6.0).amplitude == 0.0


def test_while_the_winch_stands_the_drum_has_no_amplitude_and_the_reference_goes_on():
    """Against half of the boom tip's speed at least, the quarter of its square."""
    check = Checked((2000, 16.0, 4.0))
    check.guard.state["authority"] = 0.0
    found = check.guard.step(Seen(tip_rate=2.0, payout_rate=6.0), 0.0, 1.0, inhibits=False)
    assert found.drum == 0.0
    assert check.guard.state["drum"]["now"][0] == pytest.approx(4.0 + 0.25 * (0.25 * 4.0 - 4.0))
