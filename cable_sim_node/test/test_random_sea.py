"""The linear answer to a Gaussian sea: against closed forms of one mass on a spring, and a mean over a sample."""

import numpy as np
import pytest
from cable_sim_node.vertical.axial_line import AxialLine, AxialSection, AxialUnit
from cable_sim_node.vertical.random_sea import gaussian_drag, sea_transfer_function

OMEGAS = np.linspace(0.15, 4.0, 250)


def _density(sigma: float, middle: float = 0.8, width: float = 0.1) -> np.ndarray:
    shape = np.exp(-0.5 * ((OMEGAS - middle) / width) ** 2)
    return sigma**2 * shape / (shape.sum() * (OMEGAS[1] - OMEGAS[0]))


def _line(stiffness: float, inertia: float, drag: float = 0.0, length: float = 10.0) -> AxialLine:
    """Return one mass on a spring of `stiffness` [N/m]: the cable has next to no mass."""
    section = AxialSection(length, stiffness * length, 1e-6, 0.0)
    return AxialLine((section,), AxialUnit(inertia, 1e5, drag))


def test_a_short_stiff_cable_carries_mass_times_acceleration() -> None:
    found = sea_transfer_function(_line(1e10, 24e3), 10.0, OMEGAS, _density(0.5))
    assert np.abs(found.unit_heave) == pytest.approx(np.ones(OMEGAS.size), rel=1e-4)
    assert np.abs(found.top_tension) == pytest.approx(24e3 * OMEGAS**2, rel=1e-4)


def test_drag_is_that_of_the_speed_it_makes_itself() -> None:
    k, m, drag, density = 2e4, 24e3, 6e3, _density(0.5)
    found = sea_transfer_function(_line(k, m, drag), 10.0, OMEGAS, density)
    speed = np.sqrt(np.sum(np.abs(OMEGAS * found.unit_heave) ** 2 * density) * (OMEGAS[1] - OMEGAS[0]))
    damping = np.sqrt(8.0 / np.pi) * drag * speed  # Borgman 1967
    exact = k / (k - m * OMEGAS**2 + 1j * damping * OMEGAS)
    assert found.unit_heave == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize(("sigma", "speed"), [(0.5, 0.0), (0.5, 0.3), (0.1, 1.0)])
def test_linear_drag_is_the_mean_slope_of_quadratic_drag(sigma: float, speed: float) -> None:
    sample = speed + sigma * np.random.default_rng(1).standard_normal(400_000)
    assert gaussian_drag(np.array(sigma), speed) == pytest.approx(np.mean(2.0 * np.abs(sample)), rel=5e-3)


def test_a_mean_speed_damps_the_resonance() -> None:
    line, density = _line(2e4, 24e3, 6e3), _density(0.1, middle=np.sqrt(2e4 / 24e3))
    still = sea_transfer_function(line, 10.0, OMEGAS, density)
    lowered = sea_transfer_function(line, 10.0, OMEGAS, density, speed=0.5)
    assert np.abs(lowered.unit_heave).max() < 0.7 * np.abs(still.unit_heave).max()
