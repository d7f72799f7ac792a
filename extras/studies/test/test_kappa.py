"""The bounds of kappa: the optimum of a known sea, and no knob of the controller moves them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from heave_bringup.scenarios import load_scenario
from heave_studies.kappa import bounds_of, true_parameters
from winch_controller_node.design.bounds import BOUND_STEP, boom_tip_realisation, recorded_spectrum, sensor_bound
from winch_controller_node.design.design import design_controller
from winch_controller_node.design.prediction import estimation_bound
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.parameters.model import CableModelParameters

NAME = "b3_deep_900"


def record(duration: float) -> np.ndarray:
    """A record of the boom tip from the shaping filter of the design sea."""
    assumed = load_scenario(NAME).parameters["winch_controller"]
    return boom_tip_realisation(assumed.sea, assumed.vessel, duration=duration, step=BOUND_STEP, seed=1)


KNOBS = (
    "cable_model.disturbance=0.01",
    "cable_model.inertia_factor=1.3",
    "sea.peak_period=7",
    "winch.time_constant=0.4",
    "winch.disturbance=0.2",
    "sensors.depth.noise=0.2",
    "weights.unit_heave=0.01",
    "mpc.command=0.5",
)


@pytest.fixture(scope="module")
def nominal() -> tuple[float, float]:
    return bounds_of(load_scenario(NAME), record(300.0), BOUND_STEP)


def test_what_the_controller_believes_moves_no_bound(nominal: tuple[float, float]) -> None:
    turned = load_scenario(NAME, settings=[f"winch_controller.{knob}" for knob in KNOBS])
    assert bounds_of(turned, record(300.0), BOUND_STEP) == nominal


@pytest.mark.parametrize("change", ["wave_vessel.mru.rate_noise=0.05", "virtual_winch.command_delay=0.4"])
def test_worse_sensors_and_a_later_winch_raise_the_bound(change: str, nominal: tuple[float, float]) -> None:
    changed = load_scenario(NAME, settings=[change])
    assert bounds_of(changed, record(300.0), BOUND_STEP)[0] > nominal[0]


def test_the_bound_from_a_record_is_that_of_the_filter_it_was_drawn_from() -> None:
    truth = true_parameters(load_scenario(NAME))
    quiet = dataclasses.replace(
        truth,
        cable_model=CableModelParameters(disturbance=0.0),
        winch=dataclasses.replace(truth.winch, disturbance=0.0),
    )
    exact = estimation_bound(design_controller(quiet, tick_period=0.05))
    # an hour: some 400 waves, and a filter of 8 states for one of 8
    found = sensor_bound(truth, 0.05, recorded_spectrum(record(3600.0), BOUND_STEP))
    assert found == pytest.approx(exact, rel=0.08)


def test_a_record_without_motion_has_no_bounds() -> None:
    with pytest.raises(DesignError, match="no density is above 0"):
        bounds_of(load_scenario(NAME), np.zeros(3000), BOUND_STEP)
