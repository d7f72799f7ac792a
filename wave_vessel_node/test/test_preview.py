"""The preview of the boom tip is the boom tip that comes, but for its error; without one nothing changes."""

from dataclasses import replace

import numpy as np
import pytest
from heave_msgs.msg import HeavePreview
from rclpy.serialization import deserialize_message
from wave_vessel_node.component import WaveVessel
from wave_vessel_node.parameters import PreviewParameters, WaveVesselParameters

from wave_vessel_node import conversions

DT, TICKS = 0.05, 300
SEAS = {
    "components": WaveVesselParameters(ramp=2.0, boom_tip_height=3.0),
    "filter": WaveVesselParameters(boom_tip_source="filter"),
    "regular": WaveVesselParameters(boom_tip_source="regular", ramp=5.0),
}


def run(parameters, seed=3):
    vessel = WaveVessel(parameters, seed=seed, tick_period=DT)
    return [vessel.step(tick) for tick in range(1, TICKS + 1)]


@pytest.mark.parametrize("sea", SEAS)
def test_what_is_seen_ahead_comes(sea):
    parameters = replace(SEAS[sea], preview=PreviewParameters(4.0, 0.0))
    outputs = run(parameters)
    heave = np.array([one.boom_tip.position[2] for one in outputs]) - parameters.boom_tip_height
    for index in (0, 17, 200):
        preview = outputs[index].preview
        assert preview.stamp == (index + 1) * 50_000_000
        np.testing.assert_allclose(preview.ahead, DT * np.arange(1, 81))
        np.testing.assert_array_equal(preview.heave, heave[index : index + 80])


def test_its_error_is_as_stated_and_a_moment_keeps_its_error():
    parameters = replace(SEAS["components"], preview=PreviewParameters(4.0, 0.2))
    outputs = run(parameters)
    truth = run(replace(parameters, preview=PreviewParameters(4.0, 0.0)))
    errors = [seen.preview.heave - true.preview.heave for seen, true in zip(outputs, truth, strict=True)]
    first = np.array([error[0] for error in errors])
    # of 300 samples: within four standard errors of sigma, 0.2 / sqrt(2 * 300)
    assert np.std(first) == pytest.approx(0.2, abs=4 * 0.2 / np.sqrt(600))
    np.testing.assert_array_equal(errors[10][10:], errors[20][:-10])


def test_the_sea_and_the_readings_are_the_same_with_a_preview_and_without():
    plain, seen = run(SEAS["filter"]), run(replace(SEAS["filter"], preview=PreviewParameters(4.0)))
    assert all(one.preview is None for one in plain)
    for one, other in zip(plain, seen, strict=True):
        assert one.mru == other.mru
        np.testing.assert_array_equal(one.boom_tip.position, other.boom_tip.position)


def test_a_preview_travels_without_loss():
    """The message has all that the controller reads of it."""
    preview = run(replace(SEAS["regular"], preview=PreviewParameters(1.0)))[5].preview
    message = deserialize_message(conversions.preview_message(preview, 0.05), HeavePreview)
    assert list(message.ahead) == list(preview.ahead)
    assert list(message.heave) == list(preview.heave)
    assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == preview.stamp
    assert message.heave_sigma == 0.05
