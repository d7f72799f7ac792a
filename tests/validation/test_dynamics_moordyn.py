"""The same line in MoorDyn and here, side by side, sample by sample (the peer is a test dependency)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.validation.peers.driven_run import first_harmonic, ramped_sine, run_driven
from tests.validation.peers.moordyn import RK2, RK4, run_moordyn
from tests.validation.peers.reference_systems import s300, s900

pytest.importorskip("moordyn")


@pytest.mark.parametrize("omega", [0.628, 1.256])
def test_the_300_m_line_moves_as_moordyns(omega, gallery):
    """Vertical drive of 1 m: amplitude and phase of the same 20 segments; both are second-order in space."""
    motion = ramped_sine((0.0, 0.0, 1.0), omega, 40.0)
    peer = run_moordyn(s300(20), motion, duration=140.0)
    own = run_driven(s300(20, time_step=0.025), (0.0, 0.0, 1.0), omega, duration=140.0, window=60.0, ramp=40.0)
    window = peer.times > 80.0 + 1e-9
    times, heave = peer.times[window], peer.unit[window, 2]

    def draw(figure):
        axes = figure.subplots()
        axes.plot(times, heave, label="MoorDyn")
        axes.plot(own.times, own.unit[:, 2], "--", label="this solver")
        axes.set_xlabel("time [s]")
        axes.set_ylabel("unit z [m]")
        axes.legend()

    gallery(f"moordyn_300_{omega}", f"300 m system at {omega} rad/s, 1 m vertical: unit heave of both codes.", draw)
    mean, size, phase = first_harmonic(times, heave, omega)
    assert own.unit_heave_amplitude == pytest.approx(size, rel=1e-3)
    assert own.unit_heave_phase == pytest.approx(phase, abs=1e-3)
    assert own.unit_heave_mean == pytest.approx(mean, abs=1e-4)
    assert own.unit[:, 2] == pytest.approx(heave, abs=0.01)


def test_the_300_m_line_sways_as_moordyns():
    """Oblique drive, where drag across the cable and its added mass matter."""
    motion = ramped_sine((1.0, 1.0, 0.0), 0.628, 40.0)
    peer = run_moordyn(s300(20), motion, duration=120.0)
    own = run_driven(s300(20), (1.0, 1.0, 0.0), 0.628, duration=120.0, window=60.0, ramp=40.0)
    sway = peer.unit[peer.times > 60.0 + 1e-9, 0]
    swing = np.ptp(sway)
    # the unit's drag is by axis here (thesis) and isotropic in the peer: sqrt(2) times as much for this direction
    assert np.ptp(own.unit[:, 0]) == pytest.approx(swing, rel=0.03)


def test_the_900_m_line_moves_as_moordyns():
    motion = ramped_sine((0.0, 0.0, 1.0), 2.0 * np.pi / 8.0, 60.0)
    peer = run_moordyn(s900(40), motion, duration=150.0)
    own = run_driven(
        s900(40, time_step=0.025), (0.0, 0.0, 1.0), 2.0 * np.pi / 8.0, duration=150.0, window=64.0, ramp=60.0
    )
    window = peer.times > 86.0 + 1e-9
    times, heave = peer.times[window], peer.unit[window, 2]
    _, size, phase = first_harmonic(times, heave, 2.0 * np.pi / 8.0)
    assert own.unit_heave_amplitude == pytest.approx(size, rel=5e-3)
    assert math.remainder(own.unit_heave_phase - phase, 2.0 * math.pi) == pytest.approx(0.0, abs=0.01)
    _, pull, _ = first_harmonic(times, peer.tension[window], 2.0 * np.pi / 8.0)
    assert own.tension_amplitude == pytest.approx(pull, rel=0.02)  # half a segment lies between the two readings
    # what is left is the peer's own start: its nodes begin evenly spaced, not in equilibrium
    assert own.unit[:, 2] == pytest.approx(heave, abs=0.02 * np.ptp(heave))


def test_steps_end_at_the_stability_limits_of_the_schemes():
    # RK4 on the imaginary axis: 2 sqrt 2 (Hairer and Wanner, IV.2); RK2 at 120 degrees: R(2 e^(i 120 deg)) = -1
    assert RK4.stability_limit() == pytest.approx(2.0 * math.sqrt(2.0), abs=2e-4)
    assert RK2.stability_limit() == pytest.approx(2.0, abs=2e-4)
