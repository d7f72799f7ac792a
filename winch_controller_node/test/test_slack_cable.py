"""A unit below a cable that goes slack, against quadratures of a x'' = max(x0 - x, -W/k) by scipy."""

import numpy as np
import pytest
from heave_node.numerics.linear_model import LinearModel, interconnect, linear_model
from heave_node.numerics.linear_sampling import discretise
from scipy.integrate import solve_ivp
from winch_controller_node.model.blocks import CableModel, cable_block
from winch_controller_node.model.estimator import KalmanEstimator, Measurement, MeasurementModel
from winch_controller_node.model.simulated_unit import cable_slack

CABLE = CableModel(a=7.0, b=0.0, stiffness=17.5e3, unit_weight=35e3)
"""A unit of 120 t that weighs 35 kN in water: slack where the boom tip is more than 2 m below it, by the stretch."""

DT = 0.05


def lowered_model() -> LinearModel:
    """Return the unit below a boom tip at rest, and a drum that stands."""
    drum = linear_model([[0.0]], states=("payout",), inputs={"rate": [1.0]}, outputs={"payout": [1.0]})
    tip = linear_model(np.zeros((0, 0)), states=(), outputs={"boom_tip_heave": []})
    return discretise(interconnect([cable_block(CABLE), drum, tip]), DT)


def hanging_unit(measured: tuple[str, ...] = ()) -> KalmanEstimator:
    """Return an estimator of it that knows the state at first, with sensors of what is `measured`."""
    model = lowered_model()
    measurements = [MeasurementModel(name, name, model.row(name), 1.0) for name in measured]
    slack = cable_slack(model, CABLE, measurements)
    return KalmanEstimator(model, measurements, np.zeros((3, 3)), slack=slack)


def started(estimator: KalmanEstimator, heave: float) -> KalmanEstimator:
    """Return the `estimator` with the unit at rest so far above where it hangs."""
    state = np.zeros(3)
    state[estimator.model.state("unit_heave")] = heave
    estimator.reset(state)
    return estimator


@pytest.mark.parametrize("heave", [1.9, 6.0], ids=["taut", "slack"])
def test_a_unit_above_its_slack_cable_sinks_by_its_weight_alone(heave):
    times = DT * np.arange(250)
    estimator = started(hanging_unit(), heave)
    unit = estimator.model.state("unit_heave")
    foreseen = [estimator.step(tick, 0.0, [])[unit] for tick in range(250)]
    exact = solve_ivp(
        lambda _, x: [x[1], max(-x[0], -CABLE.unit_weight / CABLE.stiffness) / CABLE.a],
        (0.0, times[-1]),
        [heave, 0.0],
        t_eval=times,
        rtol=1e-9,
        atol=1e-9,
    ).y[0]
    # the slack is that at the start of a tick; without it the unit would be metres lower within a swing
    assert np.array(foreseen) == pytest.approx(exact, abs=0.02 * heave)


def test_a_slack_cable_makes_the_estimate_less_sure():
    variances = []
    for heave in (2.0, 3.0, 5.0):
        estimator = started(hanging_unit(), heave)
        for tick in range(3):
            estimator.step(tick, 0.0, [])
        variances.append(estimator.covariance[1, 1])
    assert variances[0] == 0.0 < variances[1] < variances[2]


def test_the_tension_of_a_slack_cable_tells_less_the_slacker_it_is_and_depth_as_much_as_ever():
    sigmas = []
    for heave in (1.0, 3.0, 4.0):
        estimator = started(hanging_unit(("tension", "unit_heave")), heave)
        estimator.step(0, 0.0, [Measurement("tension", 0.0, 0), Measurement("unit_heave", 0.0, 0)])
        sigmas.append([estimator.innovations[name].sigma for name in ("tension", "unit_heave")])
    slack = CABLE.stiffness * np.array([0.0, 1.0, 2.0])
    assert np.array(sigmas) == pytest.approx(np.array([np.hypot(1.0, slack), np.ones(3)]).T)
