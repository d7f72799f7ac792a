"""Law mpc with a preview of the boom tip: the best command for what is seen ahead, and the plain law without one."""

import numpy as np
import pytest
from winch_controller_node.design.design import design_controller
from winch_controller_node.interface.readings import HeavePreview
from winch_controller_node.laws.law import LawDesign
from winch_controller_node.laws.mpc import ConstrainedLaw, MpcParameters
from winch_controller_node.laws.parts.loop_state import LoopState, Reference
from winch_controller_node.laws.parts.preview import PreviewReader, feedforward
from winch_controller_node.model.lqr import output_cost
from winch_controller_node.model.regulator import full_gain
from winch_controller_node.node_parameters import WinchControllerParameters

DT, AHEAD = 0.05, 120


@pytest.fixture(scope="module")
def design():
    return design_controller(WinchControllerParameters(), tick_period=DT)


def law_of(design, **parameters):
    p = design.parameters
    made_for = LawDesign(design.model, p.winch, design.limits, p.weights, design.gain)
    return ConstrainedLaw(made_for, MpcParameters(**parameters))


def sea_of(design, ticks, seed=1):
    """Return noise of the model's waves at each tick, shape (ticks, n), and the boom tip's heave that it makes."""
    model = design.model
    values, vectors = np.linalg.eigh(design.sea_noise)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    noise = np.random.default_rng(seed).standard_normal((ticks, model.order)) @ root.T
    x, heave = np.zeros(model.order), []
    for w in noise:
        heave.append(float(model.row("boom_tip_heave") @ x))
        x = model.A @ x + w
    return noise, np.array(heave)


def run(design, law, preview_error=None, ticks=3000):
    """Return the unit's heave in the model's own sea, its state known to the law, no limit in the way."""
    model = design.model
    noise, heave = sea_of(design, ticks + AHEAD + 1)
    x, unit = np.zeros(model.order), []
    for k in range(ticks):
        preview = None
        if preview_error is not None:
            preview = HeavePreview(DT * np.arange(1, AHEAD + 1), heave[k + 1 : k + 1 + AHEAD] + preview_error)
        state = LoopState(x, Reference(), design.cable.static_tension, preview=preview)
        unit.append(float(model.row("unit_heave") @ x))
        x = model.A @ x + model.B[:, 0] * law.command(state).value + noise[k]
    return np.array(unit[500:])


def test_a_preview_of_five_seconds_leaves_half_of_what_prediction_leaves(design):
    """The rest is what the weight on the command leaves: what is to come is known from the preview, not predicted."""
    plain = run(design, law_of(design)).std()
    seen = run(design, law_of(design, preview_time=5.0, preview_noise=0.001), preview_error=0.0).std()
    assert seen < 0.55 * plain


def test_the_law_without_a_preview_is_the_law_that_knows_of_none(design):
    plain = run(design, law_of(design), ticks=800)
    assert np.array_equal(plain, run(design, law_of(design, preview_time=5.0), ticks=800))
    assert np.array_equal(plain, run(design, law_of(design), preview_error=0.0, ticks=800)), "off by default"


def test_the_commands_for_what_is_seen_are_the_best_ones(design):
    """Any other commands for the same known disturbance cost more: the cost summed over a run, not the costate."""
    model, p = design.model, MpcParameters(preview_time=4.0)
    sizes = {"unit_heave": p.unit_heave, "payout": p.payout, "payout_acceleration": p.payout_acceleration}
    gain = full_gain(model, output_cost(model, sizes, p.command))
    disturbances = PreviewReader(model, 4.0, 0.05).disturbances
    innovation = np.sin(0.7 * np.arange(disturbances.shape[2]))
    best = feedforward(model, gain, sizes, p.command, disturbances) @ innovation

    def cost(fed):
        """Return the sum over ten minutes of (y/size)^2 + (u/size)^2."""
        x, total = np.zeros(model.order), 0.0
        rows = np.array([model.row(name) / size for name, size in sizes.items()])
        through = np.array([model.D[model.output_names.index(name), 0] / size for name, size in sizes.items()])
        for k in range(12_000):
            u = -float(gain @ x) + (fed[k] if k < len(fed) else 0.0)
            total += float(np.sum((rows @ x + through * u) ** 2)) + (u / p.command) ** 2
            x = model.A @ x + model.B[:, 0] * u
            if k < len(disturbances):
                x = x + disturbances[k] @ innovation
        return total

    least = cost(best)
    random = np.random.default_rng(1)
    for _ in range(2):
        change = 0.05 * np.abs(best).max() * random.standard_normal(len(best))
        more, less = cost(best + change), cost(best - change)
        assert min(more, less) > least
        # at the least sum the first derivative vanishes: both sides cost the same
        assert abs(more - less) < 1e-3 * (more + less - 2.0 * least)
    assert cost(0.0 * best) > least


def test_a_preview_that_is_too_short_or_broken_is_not_used(design):
    reader, x = PreviewReader(design.model, 5.0, 0.05), np.zeros(design.model.order)
    ahead = DT * np.arange(1, AHEAD + 1)
    assert reader.innovation(HeavePreview(ahead, np.ones(AHEAD)), x) == pytest.approx(np.ones(20))
    assert reader.innovation(HeavePreview(ahead[:90], np.ones(90)), x) is None
    assert reader.innovation(HeavePreview(ahead, np.full(AHEAD, np.nan)), x) is None
    assert reader.innovation(HeavePreview(ahead[:0], ahead[:0]), x) is None
    assert reader.innovation(None, x) is None
