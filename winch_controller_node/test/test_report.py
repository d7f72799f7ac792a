"""The design report: its numbers hang together, and it can be read by people and machines."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from heave_node.parameters import build_parameters
from winch_controller_node.design.report import PRESCRIBED, design_report, knee
from winch_controller_node.design.report_figures import draw_report
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters


def parameters(**values):
    named = {"cable_model.inertia": 2.0, "cable_model.damping": 0.3}
    named |= {name.replace("__", "."): value for name, value in values.items()}
    return build_parameters(WinchControllerParameters, named, where="test")


@pytest.fixture(scope="module")
def report():
    return design_report(parameters(), tick_period=0.05)


def test_a_lighter_command_weight_buys_less_motion_with_more_winch(report):
    sigma = [point.unit_sigma for point in report.weight_curve]
    rate = [point.rate_sigma for point in report.weight_curve]
    assert np.all(np.diff(sigma) < 1e-4 * sigma[0])
    assert np.all(np.diff(rate) > -1e-4 * rate[-1])
    assert sigma[0] > 2.0 * sigma[-1]


def test_along_the_winch_curve_the_motion_is_the_prescribed_one_and_a_slow_winch_needs_more_command(report):
    for point in report.winch_curve:
        assert point.unit_sigma == pytest.approx(PRESCRIBED * report.prediction.sigma["unit_heave"], rel=0.05)
    command = [point.command_sigma for point in report.winch_curve]
    assert command[-1] > 1.3 * command[0]
    assert report.winch_curve[0].parameter < knee(report.winch_curve) < report.winch_curve[-1].parameter


def test_kappa_and_power_follow_from_the_other_numbers(report):
    sigma = report.prediction.sigma
    assert report.kappa == pytest.approx(sigma["unit_heave"] / math.hypot(report.s_est, report.s_act))
    assert report.kappa >= 1.0
    # mean of abs of a Gaussian is sqrt(2/pi) sigma
    expected = math.sqrt(2.0 / math.pi) * report.design.cable.static_tension * sigma["payout_rate"]
    assert report.power_mean == pytest.approx(expected)


def test_the_table_names_every_state_and_output(report):
    table = report.table()
    for name in report.design.model.state_names + tuple(report.prediction.sigma):
        assert name in table
    for words in (
        "gain margin",
        "delay margin",
        "sensitivity peak",
        "kappa",
        "no benefit from a winch lag below",
        "within the limits",
    ):
        assert words in table


def test_a_gain_that_may_rise_without_limit_is_said_in_words(report):
    margins = replace(report.margins_state, gain_up=math.inf, gain_down=0.5)
    assert "gain margin unlimited (down x0.5)" in replace(report, margins_state=margins).table()
    assert "inf" not in replace(report, margins_state=margins).table()


def test_the_values_are_plain_json_without_nan(report):
    text = json.dumps(report.values(), allow_nan=False)
    assert json.loads(text)["kappa"] == report.kappa


def test_the_figures_are_drawn_with_units_on_their_axes(report, tmp_path):
    files = draw_report(report, tmp_path / "figures")
    assert [path.name for path in files] == [
        "design_poles.svg",
        "design_loop.svg",
        "design_weight.svg",
        "design_winch.svg",
    ]
    assert all(path.stat().st_size > 5000 for path in files)


def test_a_curve_that_no_winch_reaches_has_no_knee():
    with pytest.raises(DesignError, match="no winch"):
        knee([])
