"""White noise through a shaping filter and the vessel."""

from __future__ import annotations

import numpy as np
from heave_node.numerics.linear_model import LinearModel, covariance_factor, state_covariance
from heave_node.numerics.linear_sampling import sampled_matrices
from heave_node.numerics.randomness import random_stream

from wave_vessel_node.sea.shaping_filter import shaping_filter
from wave_vessel_node.sources.motion_source import MotionSource
from wave_vessel_node.sources.scene import Scene
from wave_vessel_node.vessel.motion import HEAVE, VesselMotions
from wave_vessel_node.vessel.second_order import SecondOrderVessel, boom_tip_model


def build(scene: Scene) -> MotionSource:
    """Return the source `filter` of a scene."""
    assert scene.spectrum is not None
    form = scene.parameters.filter
    waves = shaping_filter(scene.spectrum, form.form, form.states)
    return FilterSource(waves, scene.vessel, scene.seed, scene.tick_period)


class FilterSource(MotionSource):
    """White noise through a shaping filter and the second-order vessel, sampled exactly; begins stationary.

    Parameters
    ----------
    waves : shaping filter with the output wave_elevation
    vessel : None where the boom tip follows the surface; its acceleration is then that of the filter without its white
        part
    seed : of the noise
    tick_period : [s]
    """

    def __init__(self, waves: LinearModel, vessel: SecondOrderVessel | None, seed: int, tick_period: float) -> None:
        system = boom_tip_model(waves, vessel)
        self._transition, _, noise = sampled_matrices(system, tick_period)
        self._noise_factor = covariance_factor(noise)
        self._generator = random_stream(seed, "wave_vessel/shaping_filter")
        start = covariance_factor(state_covariance(system))
        self._state = start @ self._generator.standard_normal(system.order)
        self._next_tick = 1
        rate = system.row("boom_tip_heave_rate")
        self._outputs = np.array([system.row("wave_elevation"), system.row("boom_tip_heave"), rate, rate @ system.A])
        self._tick_period = tick_period

    def motions(self, ticks: range) -> VesselMotions:
        """See MotionSource."""
        states = []
        for _ in range(self._next_tick, ticks.stop):
            noise = self._noise_factor @ self._generator.standard_normal(self._state.size)
            self._state = self._transition @ self._state + noise
            states.append(self._outputs @ self._state)
        self._next_tick = ticks.stop
        values = np.array(states[-len(ticks) :])
        motions = VesselMotions.still(ticks, self._tick_period)
        motions.elevation = values[:, 0]
        motions.six[:, :, HEAVE] = values[:, 1:]
        return motions
