"""What a sea asks of the winch, and the share of it that a law may be given: by sines, of which all is known."""

import math

import numpy as np
import pytest
from heave_core.look import RunningSigma
from winch_controller_node.core.supervision.guard_checks import (
    GROUP_PEAK,
    GROWING_PEAK,
    PEAK,
    SLOW_MEAN_FACTOR,
    GuardedLoop,
    guard_design,
)
from winch_controller_node.laws.parts.effort import Effort
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.parameters.laws import GuardParameters

from tests.supervised import Guard, Seen

DT = 0.05
FIRST_LOOK = 120.0
"""Time for which a sea may be seen to grow [s]."""
OMEGA = 1.0
FAST = WinchLimits(speed=100.0, acceleration=1.5, payout_minimum=-50.0, payout_maximum=50.0)
STRONG = WinchLimits(speed=2.0, acceleration=100.0, payout_minimum=-50.0, payout_maximum=50.0)
NO_MORE = Effort()
SIGMA = math.sqrt(0.5)
"""Standard deviation of a sine of amplitude 1."""


class WinchDemand:
    """What a guard makes of a boom tip, asked for any limits and law."""

    def __init__(self, window):
        self._parameters = GuardParameters(window=window)
        self._guard = Guard(self._design(STRONG, Effort()))

    def _design(self, limits, effort):
        return guard_design(self._parameters, GuardedLoop(limits, effort), DT)

    def add(self, rate):
        self._guard.step(Seen(tip_rate=rate), 0.0, 1.0, inhibits=False)

    def _asked(self, limits, effort):
        self._guard.take_design(self._design(limits, effort))
        return self._guard.verdict

    def significant(self, limits):
        return self._asked(limits, Effort()).demand

    def coming(self, limits):
        return self._asked(limits, Effort()).coming

    def largest_share(self, limits, effort=NO_MORE):
        return self._asked(limits, effort).usual_authority


def sine(amplitude, seconds, growth=0.0):
    """Return the demand of a boom tip whose speed is a sine of an amplitude that grows by `growth` [1/s]."""
    demand = WinchDemand(40.0)
    for time in DT * np.arange(round(seconds / DT)):
        demand.add((amplitude + growth * time) * math.sin(OMEGA * time))
    return demand


def test_the_share_keeps_the_peaks_of_speed_within_what_may_be_used():
    share = sine(2.0, 400.0).largest_share(STRONG)
    assert share == pytest.approx(0.85 / (PEAK * SIGMA * 2.0 / 2.0), rel=0.02)


@pytest.mark.parametrize(("peak", "share"), [(0.8, 1.0), (0.95, 0.85 / 0.95)])
def test_peaks_that_need_a_little_more_than_may_be_used_are_given_a_little_less(peak, share):
    found = sine(peak * 2.0 / (PEAK * SIGMA), 400.0).largest_share(STRONG)
    assert found == pytest.approx(share, rel=0.02)


def test_the_share_keeps_the_peaks_of_acceleration_within_what_may_be_used():
    share = sine(2.0, 400.0).largest_share(FAST)
    assert share == pytest.approx(0.85 / (PEAK * SIGMA * 2.0 * OMEGA / 1.5), rel=0.02)


@pytest.mark.parametrize(("limits", "effort"), [(STRONG, Effort(speed=1.5)), (FAST, Effort(acceleration=1.5))])
def test_a_law_that_asks_for_more_than_the_sea_is_given_less_of_it(limits, effort):
    demand = sine(2.0, 400.0)
    usual = demand.largest_share(limits)
    assert demand.largest_share(limits, effort) == pytest.approx(usual / 1.5)


def test_a_calm_sea_is_given_as_a_whole():
    assert sine(0.01, 60.0).largest_share(STRONG) == 1.0
    assert WinchDemand(40.0).largest_share(STRONG) == 1.0


def sigma_of_group(values):
    """Return the standard deviation over the last 8 s of `values` about a mean that follows three times more slowly."""
    sigma = RunningSigma(8.0, DT, SLOW_MEAN_FACTOR)
    for value in values:
        sigma.add(value)
    return sigma.sigma


@pytest.mark.parametrize("limits", [STRONG, FAST], ids=["speed", "acceleration"])
def test_a_group_of_high_waves_is_seen_before_the_mean_of_the_sea_has_grown(limits):
    """Ten minutes of 0.2 m/s, then two waves of 3 m/s: peaks are 2.2 times the sigma of 8 s."""
    demand = sine(0.2, 600.0)
    group = [(0.2 if limits is STRONG else 0.2 * OMEGA) * math.sin(OMEGA * time) for time in np.arange(0.0, 100.0, DT)]
    for time in DT * np.arange(round(12.0 / DT)):
        rate = 3.0 * math.sin(OMEGA * time)
        demand.add(rate)
        group.append(rate if limits is STRONG else 3.0 * OMEGA * math.cos(OMEGA * time))
    limit = limits.usual_speed if limits is STRONG else limits.acceleration
    peak = GROUP_PEAK * sigma_of_group(group)
    assert demand.largest_share(limits) == pytest.approx(0.85 * limit / peak, rel=0.02)


@pytest.mark.parametrize("limits", [STRONG, FAST], ids=["speed", "acceleration"])
def test_a_sea_that_grows_from_its_first_wave_on_is_as_high_as_its_last_waves(limits):
    """Amplitudes grow by 0.05 m/s each second: of the last 8 s they are 2.6 m/s, 2 sigma above any crest."""
    demand = sine(0.0, 60.0, growth=0.05)
    limit = limits.usual_speed if limits is STRONG else limits.acceleration
    time = DT * np.arange(round(60.0 / DT))
    waves = 0.05 * time * (np.sin(time) if limits is STRONG else np.cos(time))
    crest = float(np.max(np.abs(waves)))
    assert demand.coming(limits) == pytest.approx(crest / limit, rel=0.01)
    assert demand.significant(limits) < 0.95 * demand.coming(limits)
    peak = GROWING_PEAK * sigma_of_group(waves)
    assert demand.largest_share(limits) == pytest.approx(0.85 * limit / peak, rel=0.03)


def test_waves_of_one_height_ask_for_their_height_and_the_highest_is_forgotten_within_minutes():
    """Of 2 sigma = 1.41 and the crest of 1 the smaller counts; of a calm after it e^(-t/300 s) of the crest is left."""
    demand = sine(1.0, 300.0)
    assert demand.significant(STRONG) == pytest.approx(1.0 / 2.0, rel=0.02)
    assert demand.significant(FAST) == pytest.approx(OMEGA / 1.5, rel=0.02)


def stepped(seconds, energy, amplitude):
    """Return the demand of a sea of an `amplitude` [m/s] whose later half has so many times the energy.

    One crest is before it, of five times the amplitude.
    """
    demand = WinchDemand(1e4)
    demand.add(5.0 * amplitude)
    for time in DT * np.arange(round(seconds / DT)):
        height = amplitude * (1.0 if time < 0.5 * seconds else math.sqrt(energy))
        demand.add(height * math.sin(math.pi * time / 4.0))
    return demand


@pytest.mark.parametrize("amplitude", [1.0, 0.01])
@pytest.mark.parametrize(
    ("seconds", "energy", "grows"),
    [(80.0, 3.5, False), (80.0, 4.5, True), (FIRST_LOOK - 1.0, 6.0, True), (FIRST_LOOK + 1.0, 6.0, False)],
)
def test_a_sea_that_is_seen_first_grows_if_its_later_half_has_four_times_the_energy_of_the_earlier_one(
    seconds, energy, grows, amplitude
):
    """It is then as high as the waves of its last 8 s; else as all that was seen of it. The crest is above both."""
    demand = stepped(seconds, energy, amplitude)
    seen = math.sqrt(0.5 * (1.0 + energy))
    assert demand.significant(STRONG) == pytest.approx(2.0 * SIGMA * amplitude * seen / 2.0, rel=0.03)
    assert demand.coming(STRONG) / demand.significant(STRONG) == pytest.approx(
        math.sqrt(energy) / seen if grows else 1.0, rel=0.05
    )
