"""Where the vessel's motion comes from: each source gives the motion at any tick, in order."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from heave_node.linear_model import LinearModel, covariance_factor, state_covariance
from heave_node.linear_sampling import sampled_matrices
from heave_node.randomness import random_stream

from wave_vessel_node.parameters import DriftParameters, WaveVesselParameters
from wave_vessel_node.ramp import apply_ramp
from wave_vessel_node.sea.realisation import HarmonicSum, WaveComponents, draw_components
from wave_vessel_node.sea.spectra import TabulatedSpectrum
from wave_vessel_node.vessel.course import Course
from wave_vessel_node.vessel.motion import HEAVE, PITCH, VesselMotion
from wave_vessel_node.vessel.second_order import SecondOrderVessel, boom_tip_model, wave_slope_response

_DRIFT_COMPONENTS = 120


class MotionSource(Protocol):
    """Gives the vessel's motion, without start ramp, tick by tick."""

    def motion(self, tick: int) -> VesselMotion:
        """Return the motion at tick * tick_period; ticks are asked in rising order, each once."""


class RegularSource:
    """Boom tip moved as a_i sin(omega t) along world x, y, z; the sea surface follows z."""

    def __init__(self, amplitude: tuple[float, ...], period: float, tick_period: float) -> None:
        self._amplitude = np.array(amplitude)
        self._omega = 2.0 * math.pi / period
        self._tick_period = tick_period

    def motion(self, tick: int) -> VesselMotion:
        """See MotionSource."""
        time = tick * self._tick_period
        sine, cosine = math.sin(self._omega * time), math.cos(self._omega * time)
        motion = VesselMotion(time)
        motion.displacement[:3] = self._amplitude * sine
        motion.velocity[:3] = self._amplitude * (self._omega * cosine)
        motion.acceleration[:3] = self._amplitude * (-self._omega * self._omega * sine)
        motion.elevation = float(motion.displacement[HEAVE])
        return motion


class SecondOrderSource:
    """Components through the second-order vessel (thesis Eq. 6.25), each by its exact steady response.

    `vessel` None: the boom tip follows the sea surface.
    """

    def __init__(
        self, components: WaveComponents, vessel: SecondOrderVessel | None, pitch_gain: float, tick_period: float
    ) -> None:
        omega = components.frequency
        phasor = components.amplitude * np.exp(1j * components.phase)
        response = np.ones(omega.size, dtype=complex) if vessel is None else vessel.response(omega)
        rows = [phasor, phasor * response]
        self._has_pitch = pitch_gain > 0.0 and vessel is not None
        if self._has_pitch:
            assert vessel is not None
            shape = vessel.response(omega) / vessel.gain if vessel.gain else 0.0 * response
            # bow-down pitch is positive and the waves meet the bow: the slope along their travel is the pitch
            rows.append(phasor * shape * pitch_gain * wave_slope_response(omega))
        self._sum = HarmonicSum(omega, np.vstack(rows), tick_period)
        self._tick_period = tick_period

    def motion(self, tick: int) -> VesselMotion:
        """See MotionSource."""
        values = self._sum.at(tick)
        motion = VesselMotion(tick * self._tick_period, elevation=float(values[0, 0]))
        motion.displacement[HEAVE], motion.velocity[HEAVE], motion.acceleration[HEAVE] = values[:, 1]
        if self._has_pitch:
            motion.displacement[PITCH], motion.velocity[PITCH], motion.acceleration[PITCH] = values[:, 2]
        return motion


class FilterSource:
    """White noise through a shaping filter and the second-order vessel, discretised exactly; starts stationary.

    Without a vessel the boom tip follows the surface; its acceleration is then that of the filter without its white
    part.
    """

    def __init__(self, wave: LinearModel, vessel: SecondOrderVessel | None, seed: int, tick_period: float) -> None:
        system = boom_tip_model(wave, vessel)
        self._transition, _, noise = sampled_matrices(system, tick_period)
        self._noise_factor = covariance_factor(noise)
        self._generator = random_stream(seed, "wave_vessel/shaping_filter")
        start = covariance_factor(state_covariance(system))
        self._state = start @ self._generator.standard_normal(system.order)
        self._tick = 0
        rate = system.row("boom_tip_heave_rate")
        self._outputs = np.array([system.row("wave_elevation"), system.row("boom_tip_heave"), rate, rate @ system.A])
        self._tick_period = tick_period

    def motion(self, tick: int) -> VesselMotion:
        """See MotionSource."""
        while self._tick < tick:
            noise = self._noise_factor @ self._generator.standard_normal(self._state.size)
            self._state = self._transition @ self._state + noise
            self._tick += 1
        elevation, heave, rate, acceleration = self._outputs @ self._state
        motion = VesselMotion(tick * self._tick_period, elevation=float(elevation))
        motion.displacement[HEAVE], motion.velocity[HEAVE], motion.acceleration[HEAVE] = heave, rate, acceleration
        return motion


class RampedSource:
    """Another source, growing from rest over the ramp; at the first tick (number 1) everything is still."""

    def __init__(self, source: MotionSource, parameters: WaveVesselParameters, tick_period: float) -> None:
        self._source = source
        self._ramp = parameters.ramp
        self._tick_period = tick_period

    def motion(self, tick: int) -> VesselMotion:
        """See MotionSource."""
        motion = self._source.motion(tick)
        since_start = (tick - 1) * self._tick_period
        if since_start < self._ramp:
            six = np.stack((motion.displacement, motion.velocity, motion.acceleration))
            motion.displacement, motion.velocity, motion.acceleration = apply_ramp(six, since_start, self._ramp)
            motion.elevation *= float(apply_ramp(np.array([1.0, 0.0, 0.0]), since_start, self._ramp)[0])
        return motion


class CourseSource:
    """Another source on a course: heading, rate of turn and speed are the course's (they turn the axes and disturb the
    MRU).
    """

    def __init__(self, source: MotionSource, course: Course) -> None:
        self._source = source
        self._course = course

    def motion(self, tick: int) -> VesselMotion:
        """See MotionSource."""
        motion = self._source.motion(tick)
        motion.heading = self._course.heading(motion.time)
        motion.turn_rate = self._course.turn_rate(motion.time)
        motion.turn_acceleration = self._course.turn_acceleration(motion.time)
        motion.speed = self._course.speed(motion.time)
        return motion


class DriftingSource:
    """Another source with slow drift in surge and sway added: narrow-band noise about the natural period of position
    keeping.
    """

    def __init__(self, source: MotionSource, drift: DriftParameters, seed: int, tick_period: float) -> None:
        self._source = source
        natural = 2.0 * math.pi / drift.period
        omega = np.linspace(0.05, 3.0, 300) * natural
        resonance = (natural**2 - omega**2) ** 2 + (2.0 * drift.damping_ratio * natural * omega) ** 2
        spectrum = TabulatedSpectrum(omega, 1.0 / resonance, name="slow drift")
        self._sums = []
        for axis, deviation in zip(("surge", "sway"), drift.standard_deviation, strict=True):
            generator = random_stream(seed, f"wave_vessel/drift/{axis}")
            sea = draw_components(spectrum, _DRIFT_COMPONENTS, generator)
            amplitude = sea.amplitude * deviation / math.sqrt(spectrum.moment(0))
            self._sums.append(HarmonicSum(sea.frequency, amplitude * np.exp(1j * sea.phase), tick_period))

    def motion(self, tick: int) -> VesselMotion:
        """See MotionSource."""
        motion = self._source.motion(tick)
        for axis, harmonics in enumerate(self._sums):
            value, rate, acceleration = harmonics.at(tick)[:, 0]
            motion.displacement[axis] += value
            motion.velocity[axis] += rate
            motion.acceleration[axis] += acceleration
        return motion
