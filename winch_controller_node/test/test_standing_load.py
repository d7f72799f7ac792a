"""The load under the brake: what is known of its weight, and for how long without a load cell."""

from types import SimpleNamespace

import pytest
from winch_controller_node.core.estimation.loop_tick import TENSION_MEMORY
from winch_controller_node.core.supervision.landing import HangingLoad, Landing
from winch_controller_node.core.supervision.watch.standing_load import StandingLoad
from winch_controller_node.design.design import design_controller
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.laws import TensionLawParameters

from tests.gates import MeanTension

DT = 0.05
LOAD = HangingLoad(static_tension=60e3, weight=50e3, stiffness=1e6, swing_time=8.0)


@pytest.fixture(scope="module")
def design():
    return design_controller(WinchControllerParameters(), tick_period=DT)


class Braked:
    """A winch that stands, braked, over a load whose cable carries nothing of it."""

    def __init__(self, design):
        self.landing = Landing(TensionLawParameters(), LOAD)
        self.load = StandingLoad(self.landing, design)
        self._tension = MeanTension(tick_period=DT)

    def wait(self, seconds, *, lost=(), is_wanted=True):
        """Return the codes of the alarms of so many `seconds`."""
        codes = []
        for _ in range(round(seconds / DT)):
            if not lost:
                self._tension.add(10e3, 0.0, unit_stands=False)
            lost_now = dict.fromkeys(lost, "stale")
            tick = SimpleNamespace(lost=lost_now, depths=(), sees_landing=False, mean_tension=self._tension.mean)
            codes += [one.code for one in self.load.update(tick, 0.0, LOAD, brake=True, is_wanted=is_wanted)]
        return codes


def test_a_load_that_stands_is_told_once_and_keeps_compensation_off(design):
    winch = Braked(design)
    assert winch.wait(7.0) == []
    assert winch.load.gate.startswith("averaging the tension for")
    assert winch.wait(60.0) == ["UNIT_NOT_SUSPENDED"]
    assert not winch.landing.hangs
    assert "UNIT NOT SUSPENDED" in winch.load.gate.upper().replace("_", " ")


def test_what_the_load_cell_has_said_is_kept_for_as_long_as_a_mean_remembers_and_no_longer(design):
    winch = Braked(design)
    winch.wait(20.0)
    winch.wait(TENSION_MEMORY - DT, lost=("load_cell",))
    assert not winch.landing.hangs, "a load is not lifted off because its load cell is lost"
    winch.wait(1.0)
    winch.wait(TENSION_MEMORY - DT, lost=("load_cell",))
    assert not winch.landing.hangs, "it was weighed again meanwhile"
    winch.wait(3.0 * DT, lost=("load_cell",))
    assert winch.landing.hangs
