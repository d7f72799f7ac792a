import dataclasses
import math

import numpy as np
import pytest
from heave_node.numerics.linear_model import output_sigma, output_spectrum
from heave_node.parameters import ParameterError, build_parameters
from wave_vessel_node.component import WaveVessel, boom_tip_heave
from wave_vessel_node.mru.mru import MotionReferenceUnit
from wave_vessel_node.parameters import (
    LaterSeaParameters,
    MruParameters,
    VesselParameters,
    WaveVesselParameters,
)
from wave_vessel_node.sea.shaping_filter import shaping_filter
from wave_vessel_node.sea.spectra import Bretschneider
from wave_vessel_node.sources.filtered import FilterSource
from wave_vessel_node.vessel.second_order import SecondOrderVessel, boom_tip_model

DT = 0.05


def record(parameters, ticks, seed=1):
    """Return the boom tip's position, velocity, acceleration at t_2, t_3, ... shape (3, ticks, 3)."""
    vessel = WaveVessel(parameters, seed=seed, tick_period=DT)
    tips = [vessel.step(tick).boom_tip for tick in range(1, ticks + 1)]
    return np.array(
        [[tip.position for tip in tips], [tip.velocity for tip in tips], [tip.acceleration for tip in tips]]
    )


RAO = VesselParameters(model="rao")
KINDS = {
    "spectrum": WaveVesselParameters(ramp=5.0),
    "filter": WaveVesselParameters(boom_tip_source="filter", ramp=5.0),
    "regular": WaveVesselParameters(boom_tip_source="regular", amplitude=(1.0, -0.5, 2.0), ramp=5.0),
    "direct": WaveVesselParameters(vessel=VesselParameters(model="direct"), ramp=5.0),
    "rao": WaveVesselParameters(vessel=RAO, ramp=5.0, direction=2.0),
    "fitted": WaveVesselParameters(vessel=VesselParameters(model="fitted"), ramp=5.0, direction=2.0),
    "later sea": WaveVesselParameters(
        ramp=5.0,
        later_sea=LaterSeaParameters(significant_wave_height=2.0, peak_period=6.0, start=5.0, duration=10.0),
    ),
}


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "filter"])
def test_position_velocity_and_acceleration_fit_one_another(kind):
    position, velocity, acceleration = record(KINDS[kind], 400)
    time = np.arange(3, 401) * DT
    smooth = np.abs(time - 5.0 - DT) > 2.5 * DT  # the ramp's third derivative jumps at its end
    for low, high in ((position, velocity), (velocity, acceleration)):
        simpson = DT / 3 * (high[2:] + 4 * high[1:-1] + high[:-2])
        error = np.abs(low[2:] - low[:-2] - simpson)[smooth & (time > 4 * DT)]
        # Simpson's error is h^5/90 of the fourth derivative of `high`: 1e-6 at 4 rad/s; where the boom tip follows the
        # sea, up to 8 rad/s
        assert error.max() < (1e-4 if kind == "direct" else 5e-6)


@pytest.mark.parametrize("kind", list(KINDS))
def test_a_seed_fixes_every_bit_and_another_gives_another_sea(kind):
    first, again, other = (record(KINDS[kind], 60, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    if kind != "regular":
        assert not np.array_equal(first, other)


@pytest.mark.parametrize("kind", list(KINDS))
def test_everything_is_still_at_the_first_tick(kind):
    vessel = WaveVessel(KINDS[kind], seed=1, tick_period=DT)
    tip = vessel.initial_boom_tip()
    assert tip.time == DT
    for vector in (tip.position, tip.velocity, tip.acceleration):
        np.testing.assert_array_equal(vector, np.zeros(3))


def test_a_regular_source_moves_as_a_sine_after_the_ramp():
    position, velocity, acceleration = record(KINDS["regular"], 300)
    time = np.arange(2, 302) * DT
    omega = 2 * math.pi / 10.0
    late = time > 5.0 + DT
    amplitude = np.array([1.0, -0.5, 2.0])
    for values, shape in (
        (position, np.sin(omega * time)),
        (velocity, omega * np.cos(omega * time)),
        (acceleration, -(omega**2) * np.sin(omega * time)),
    ):
        np.testing.assert_allclose(values[late], np.outer(shape, amplitude)[late], atol=1e-12)


def test_the_boom_tip_is_published_for_the_end_of_the_tick_and_the_mru_for_its_start():
    parameters = build_parameters(
        WaveVesselParameters,
        {"mru.noise": 0.0, "mru.rate_noise": 0.0, "boom_tip_height": 12.0, "ramp": 1.0},
        where="test",
    )
    vessel = WaveVessel(parameters, seed=1, tick_period=DT)
    previous = vessel.initial_boom_tip()
    for tick in range(1, 60):
        outputs = vessel.step(tick)
        assert outputs.boom_tip.time == pytest.approx((tick + 1) * DT)
        assert outputs.mru.time == pytest.approx(tick * DT)
        assert outputs.mru.heave == pytest.approx(previous.position[2] - 12.0, abs=1e-12)
        assert outputs.mru.heave_rate == pytest.approx(previous.velocity[2], abs=1e-12)
        previous = outputs.boom_tip


def test_ticks_out_of_order_are_refused():
    vessel = WaveVessel(WaveVesselParameters(), seed=1, tick_period=DT)
    vessel.step(1)
    with pytest.raises(ValueError, match="expected 2, got 4"):
        vessel.step(4)


def test_the_second_order_vessel_answers_each_component_as_eq_6_25():
    # amplitude and phase put into the differential equation x'' + 2 xi w x' + w^2 x = K w^2 cos(omega t)
    vessel = SecondOrderVessel(0.393, 0.6, 0.5)
    for omega in (0.1, 0.393, 1.2):
        H = complex(vessel.response(omega))
        x = lambda t, n=0: (H * (1j * omega) ** n * np.exp(1j * omega * t)).real  # noqa: E731, B023
        for t in (0.0, 1.3, 7.7):
            left = x(t, 2) + 2 * 0.6 * 0.393 * x(t, 1) + 0.393**2 * x(t)
            assert left == pytest.approx(0.5 * 0.393**2 * math.cos(omega * t), abs=1e-12)


def test_the_filter_source_has_the_variance_of_the_lyapunov_equation():

    wave, vessel = shaping_filter(Bretschneider(2.0, 6.0)), SecondOrderVessel(0.9, 0.4, 1.0)
    source = FilterSource(wave, vessel, seed=5, tick_period=0.5)
    heave = source.motions(range(1, 40001)).six[:, 0, 2]
    system = boom_tip_model(wave, vessel)
    # variance of a variance: 2 pi / T integral S^2, T = 20000 s
    omega = np.linspace(0.01, 4.0, 4000)
    density = output_spectrum(system, "boom_tip_heave", omega)
    sigma = math.sqrt(2 * math.pi / 20000.0 * np.trapezoid(density**2, omega))
    assert heave.var() == pytest.approx(output_sigma(system)["boom_tip_heave"] ** 2, abs=4 * sigma)


def test_what_is_published_of_the_sea_is_the_target():
    sea = WaveVessel(
        WaveVesselParameters(significant_wave_height=2.5, peak_period=9.0), seed=7, tick_period=DT
    ).sea_state()
    assert (sea.spectrum, sea.seed) == ("bretschneider", 7)
    assert sea.significant_wave_height == pytest.approx(2.5, rel=1e-6)
    assert sea.peak_period == pytest.approx(9.0)
    assert 4 * math.sqrt(np.trapezoid(sea.spectral_density, sea.angular_frequency)) == pytest.approx(2.5, rel=0.01)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"spectrum": "file"}, "needs spectrum_file"),
        ({"boom_tip_source": "file"}, "needs recording_file"),
        ({"boom_tip_source": "filter", "vessel.model": "rao"}, "not rao"),
        ({"significant_wave_height": -1.0}, "significant_wave_height = -1.0"),
        ({"significant_waveheight": 1.0}, "did you mean significant_wave_height"),
        ({"boom_tip_source": "filter", "vessel.pitch_gain": 1.0}, "no wave slope"),
        ({"boom_tip_source": "regular", "later_sea.duration": 10.0}, "later_sea needs a sea"),
        ({"boom_tip_source": "regular", "vessel.model": "fitted"}, "needs a sea spectrum"),
        ({"filter.states": 7}, "must be even"),
    ],
)
def test_parameters_that_cannot_work_are_refused_in_one_line(values, says):
    with pytest.raises(ParameterError, match=says) as error:
        build_parameters(WaveVesselParameters, values, where="my.yaml: wave_vessel")
    assert "\n" not in str(error.value)
    assert str(error.value).startswith("my.yaml: wave_vessel")


def test_a_later_sea_is_none_before_it_begins_and_all_there_is_once_it_has_come():
    first = WaveVesselParameters(ramp=0.0, significant_wave_height=1.0, peak_period=6.0)
    later = LaterSeaParameters(significant_wave_height=3.0, peak_period=12.0, start=100.0, duration=50.0)
    alone, changing = (
        record(parameters, 40_000)[0, :, 2] for parameters in (first, dataclasses.replace(first, later_sea=later))
    )
    assert np.array_equal(changing[: round(100.0 / DT) - 2], alone[: round(100.0 / DT) - 2])
    # 1,850 s of a sea of 12 s are some 300 independent values of its height: 5 sigma are 5 / sqrt(2 * 300)
    vessel = WaveVessel(
        dataclasses.replace(first, significant_wave_height=3.0, peak_period=12.0), seed=1, tick_period=DT
    )
    promised = math.sqrt(float(np.trapezoid(*_heave_spectrum(vessel))))
    assert np.std(changing[round(150.0 / DT) :]) == pytest.approx(promised, rel=5 / math.sqrt(600))


def _heave_spectrum(vessel):
    """Return the spectrum of the boom tip's heave and its frequencies, from those of the sea and the vessel."""
    omega = np.linspace(0.1, 5.0, 4000)
    scene = vessel._scene
    return scene.spectrum.density(omega) * scene.power_response(omega), omega


@pytest.mark.parametrize("vessel", ["direct", "second_order", "rao"])
def test_heave_by_one_sum_is_that_of_the_steps(vessel: str) -> None:
    parameters = WaveVesselParameters(
        components=60,
        ramp=10.0,
        vessel=VesselParameters(model=vessel, boom_tip_arm=(-20.0, 10.0, 15.0), pitch_gain=1.0),
        mru=MruParameters(rate=10.0, latency=0.1, high_pass_period=20.0, resolution=0.01),
    )
    ticks = 700
    heave = boom_tip_heave(parameters, 5, 0.05, ticks + 1)
    assert heave is not None
    ship, heaves, readings = WaveVessel(parameters, seed=5, tick_period=0.05), [], []
    for tick in range(1, ticks + 1):
        outputs = ship.step(tick)
        heaves.append([outputs.boom_tip.position[2], outputs.boom_tip.velocity[2]])
        said = outputs.mru
        readings.append([math.nan, math.nan] if said is None else [said.heave, said.heave_rate])
    np.testing.assert_allclose(heave[1:, :2], heaves, atol=1e-12)
    series = MotionReferenceUnit(parameters.mru, seed=5, tick_period=0.05).series(heave)
    np.testing.assert_allclose(series[:-1], readings, atol=1e-12)
