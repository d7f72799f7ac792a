"""Heave while the unit is lowered."""

import numpy as np
import pytest
from heave_bags.analyse import kpi_set
from heave_bags.analyse.reading.depth_programme import take_out_programme
from heave_bags.signals import RunSignals, Signal

TIME = np.arange(0.05, 900.0, 0.05)
WAVE = np.sin(2.0 * np.pi / 10.0 * TIME)
LOWERED = np.clip((TIME - 200.0) * 0.5, 0.0, 250.0)  # 250 m at 0.5 m/s
STRETCH = 0.003 * LOWERED


def lowered(shadow_follows: bool) -> RunSignals:
    off = -300.0 + 1.0 * WAVE - (LOWERED + STRETCH if shadow_follows else 0.0)
    return RunSignals(
        unit_heave=Signal(TIME, -300.0 + 0.1 * WAVE - LOWERED - STRETCH),
        uncompensated_heave=Signal(TIME, off),
        boom_tip_heave=Signal(TIME, WAVE),
        payout=Signal(TIME, 0.9 * WAVE + LOWERED),
    )


@pytest.mark.parametrize("shadow_follows", [True, False])
def test_heave_while_lowering_is_that_of_the_waves(shadow_follows):
    signals = lowered(shadow_follows)
    assert take_out_programme(signals, Signal(TIME, LOWERED))
    values = kpi_set.evaluate(signals, 60.0, 840.0)
    assert values["unit_sigma_m"] == pytest.approx(0.1 / np.sqrt(2.0), rel=0.02)
    assert values["uncompensated_sigma_m"] == pytest.approx(1.0 / np.sqrt(2.0), rel=0.02)
    assert values["outlet_efficiency"] == pytest.approx(0.9, abs=1e-6)


def test_the_static_tension_grows_by_the_weight_of_what_is_paid_out():
    signals = lowered(shadow_follows=True)
    signals.static_tension = Signal(TIME[:1], np.array([36e3]))
    take_out_programme(signals, Signal(TIME, LOWERED), 36.0)
    assert signals.static_tension.value[0] == 36e3
    assert signals.static_tension.value[-1] == pytest.approx(36e3 + 36.0 * 250.0)


def test_a_set_point_that_stays_changes_nothing():
    signals = lowered(shadow_follows=False)
    before = signals.unit_heave
    assert not take_out_programme(signals, Signal(TIME, np.full(TIME.size, 3.0)))
    assert signals.unit_heave is before
