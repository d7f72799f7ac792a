"""The load under the brake: what is known of its weight, and for how long without a load cell."""

import math

import pytest
from winch_controller_node.core.estimation.loop_tick import TENSION_MEMORY
from winch_controller_node.core.supervision.landing import HangingLoad
from winch_controller_node.core.supervision.modes import Mode

from tests.gates import MeanTension
from tests.supervised import Supervised, designed

DT = 0.05
LOAD = HangingLoad(static_tension=60e3, weight=50e3, stiffness=1e6, swing_time=8.0)


class Braked(Supervised):
    """A winch that stands, braked, over a load whose cable carries nothing of it."""

    def __init__(self):
        super().__init__(mode=Mode.STANDBY)
        self.supervisor.landing.take_load(LOAD)
        self.landing = self.supervisor.landing
        self._tension = MeanTension(tick_period=DT)

    def wait(self, seconds, *, lost=(), load=10e3):
        """Return the alarms of so many `seconds` with a `load` on the cable [N]."""
        alarms = []
        for _ in range(round(seconds / DT)):
            if not lost:
                self._tension.add(load, 0.0, unit_stands=False)
            mean = self._tension.mean
            tension = {"tension_mean": mean.value, "tension_sigma": mean.sigma, "tension_time": mean.time}
            alarms += self.step(lost=lost, sees_landing=0, **tension).alarms
        return alarms

    @property
    def gate(self):
        """What keeps compensation from beginning, in words."""
        return self.supervisor.modes.obstacle


def test_a_load_that_stands_is_told_once_and_keeps_compensation_off():
    winch = Braked()
    assert winch.wait(7.0) == []
    assert winch.gate.startswith("averaging the tension for")
    (alarm,) = winch.wait(60.0)
    assert (alarm.code, alarm.values["percent"]) == ("UNIT_NOT_SUSPENDED", 0.0)
    assert not winch.landing.hangs
    assert "UNIT NOT SUSPENDED" in winch.gate.upper().replace("_", " ")


def test_it_is_told_how_much_of_a_load_the_cable_carries():
    """17.5 of 50 kN, where 60 kN hang on it with the cable."""
    (alarm,) = Braked().wait(60.0, load=27.5e3)
    assert alarm.values["percent"] == pytest.approx(35.0)


def test_what_the_load_cell_has_said_is_kept_for_as_long_as_a_mean_remembers_and_no_longer():
    winch = Braked()
    winch.wait(20.0)
    winch.wait(TENSION_MEMORY - DT, lost=("load_cell",))
    assert not winch.landing.hangs, "a load is not lifted off because its load cell is lost"
    winch.wait(1.0)
    winch.wait(TENSION_MEMORY - DT, lost=("load_cell",))
    assert not winch.landing.hangs, "it was weighed again meanwhile"
    winch.wait(3.0 * DT, lost=("load_cell",))
    assert winch.landing.hangs


WINDOW = 8.0


def told(depth, *, payout=0.0, tolerance=0.01, known=lambda time: True, stretch=2.0 / 300.0):
    """Return the alarms of 60 s with a unit on 300 m that heaves about a `depth` at which it rests [m].

    The cable stretches by 2 m, and the boom tip is 10 m above the water.
    """
    winch, alarms = Supervised(mode=Mode.STANDBY, design=designed()), []
    winch.supervisor.landing.take_load(LOAD)
    values = {"length": 300.0, "tip_height": 10.0, "payout_tolerance": tolerance, "stretch": stretch}
    for name, value in values.items():
        winch.supervisor._design[name] = value
    for tick in range(round(60.0 / DT)):
        time = tick * DT
        depths = ((time, depth + 1.5 * math.sin(0.8 * time)),) if tick % 2 else ()
        decision = winch.step(depths=depths, sees_landing=known(time), winch={"mean_payout": payout})
        alarms += [(time, one) for one in decision.alarms if one.code == "PAYOUT_DEPTH_DISAGREE"]
    return alarms


def test_a_meter_that_reads_less_than_is_out_is_told_once_with_both_depths_after_a_wave():
    ((time, alarm),) = told(302.0)
    assert time == pytest.approx(WINDOW, abs=0.1)
    assert alarm.values["depth"] == pytest.approx(302.0, abs=0.8)


@pytest.mark.parametrize("off", [-5.0, 0.0, 5.0])
def test_what_tide_draught_and_a_hundredth_of_the_cable_may_be_off_is_not_told(off):
    assert told(292.0 + off) == []


def test_cable_that_was_paid_out_counts_and_nothing_is_compared_while_it_is_not_known_where_the_unit_is():
    assert told(292.0 + 50.0 * (1.0 + 2.0 / 300.0), payout=50.0) == []
    assert told(302.0, known=lambda time: False) == []
    assert told(302.0, known=lambda time: time % 7.0 < 6.5) == []
    assert told(302.0, tolerance=0.0) == []


def test_a_spring_whose_preload_takes_the_weight_stretches_nothing():
    """A passive compensator of 20 m of travel under the weight, at its middle."""
    assert told(290.0, stretch=20.0 / 300.0) == []
