"""The sea, the vessel and its motion reference unit as one component, stepped by tick number. No ROS."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from heave_node.arrays import Array
from heave_node.kinematics import PointMotion
from heave_node.randomness import random_stream
from heave_node.sensors import MruReading

from wave_vessel_node.motion_sources import (
    CourseSource,
    DriftingSource,
    FilterSource,
    MotionSource,
    RampedSource,
    RegularSource,
    SecondOrderSource,
)
from wave_vessel_node.mru.mru import MotionReferenceUnit, high_pass_response
from wave_vessel_node.mru.sea_state_estimate import SeaStateEstimate, SeaStateEstimator
from wave_vessel_node.parameters import WaveVesselParameters
from wave_vessel_node.sea.realisation import WaveComponents, draw_components
from wave_vessel_node.sea.sea import SeaState, build_spectrum, describe_sea
from wave_vessel_node.sea.shaping_filter import shaping_filter
from wave_vessel_node.sea.spectra import WaveSpectrum
from wave_vessel_node.vessel.course import Course
from wave_vessel_node.vessel.fit import VesselFit, boom_tip_heave_response, fit_vessel
from wave_vessel_node.vessel.motion import VesselMotion, lever_arm_matrix, point_motion
from wave_vessel_node.vessel.rao import RaoError, ResponseTable
from wave_vessel_node.vessel.rao_files import read_rao
from wave_vessel_node.vessel.rao_source import RaoSource
from wave_vessel_node.vessel.recording import RecordedSource, read_recording
from wave_vessel_node.vessel.second_order import SecondOrderVessel


@dataclass(frozen=True)
class WaveVesselOutputs:
    """What one tick k gives.

    Attributes
    ----------
    mru : the reading delivered at t_k, None if there is none (rate, gap, restart, latency at the start)
    boom_tip : true motion of the boom tip at t_{k+1}, frame world
    vessel : true motion of the vessel at t_{k+1}
    wave_elevation : sea surface below the boom tip at t_{k+1} [m]
    estimate : a new sea-state estimate from the MRU readings up to t_k, when one is due and the record long enough
    """

    mru: MruReading | None
    boom_tip: PointMotion
    vessel: VesselMotion
    wave_elevation: float
    estimate: SeaStateEstimate | None = None


class WaveVessel:
    """Sea state to boom-tip motion, and what the MRU says of it.

    Parameters
    ----------
    parameters : see WaveVesselParameters
    seed : fixes the sea and the noise
    tick_period : [s]

    `warnings` names what was repaired in the files read; `vessel_fit` is the vessel identified where the model is
    fitted.

    Raises SpectrumError, SpectrumFileError, RaoError or RecordingError when the parameters name something that cannot
    be used.
    """

    def __init__(self, parameters: WaveVesselParameters, *, seed: int, tick_period: float) -> None:
        self.parameters = parameters
        self.warnings: list[str] = []
        self._rao = self._read_rao()
        self.vessel_fit: VesselFit | None = None
        arm = np.zeros(3) if self._rao is None else np.array(parameters.vessel.boom_tip_arm)
        self._lever = lever_arm_matrix(arm)
        self._course = Course(parameters.course)
        self._spectrum: WaveSpectrum | None = None
        if parameters.boom_tip_source in ("spectrum", "filter"):
            self._spectrum = build_spectrum(parameters, self.warnings)
        self.vessel_fit = self._fit_vessel()
        self._source = self._build_source(seed, tick_period)
        self._sea_state = describe_sea(parameters, self._spectrum, seed)
        self.mru = MotionReferenceUnit(parameters.mru, seed=seed, tick_period=tick_period)
        self._estimator = self._build_estimator()
        self._ticks_between_estimates = max(1, round(parameters.estimate.period / tick_period))
        self._next_tick = 1
        self._motion = self._source.motion(1)
        self._boom_tip = self._point(self._motion)

    def sea_state(self) -> SeaState:
        """Return the sea as it is published."""
        return self._sea_state

    def initial_boom_tip(self) -> PointMotion:
        """Return the motion of the boom tip at the first tick, from which the plant starts; call it before the first
        step.
        """
        return self._boom_tip

    def step(self, tick: int) -> WaveVesselOutputs:
        """Do tick `tick`: the MRU reading of t_k, motions of t_{k+1}. Ticks come in order, from 1.

        Raises ValueError if `tick` is not the next one.
        """
        if tick != self._next_tick:
            raise ValueError(f"ticks come in order: wanted {self._next_tick}, got {tick}")
        here = self._boom_tip
        height = self.parameters.boom_tip_height
        heave = np.array([here.position[2] - height, here.velocity[2], here.acceleration[2]])
        reading = self.mru.step(tick, heave, self._motion)
        self._motion = self._source.motion(tick + 1)
        self._next_tick = tick + 1
        self._boom_tip = self._point(self._motion)
        if reading is not None:
            self._estimator.add(reading)
        estimate = self._estimator.estimate() if tick % self._ticks_between_estimates == 0 else None
        return WaveVesselOutputs(reading, self._boom_tip, self._motion, self._motion.elevation, estimate)

    def _point(self, motion: VesselMotion) -> PointMotion:
        return point_motion(motion, self._lever, self.parameters.boom_tip_height)

    def _second_order_vessel(self) -> SecondOrderVessel | None:
        vessel = self.parameters.vessel
        if vessel.model == "direct":
            return None
        if self.vessel_fit is not None:
            return self.vessel_fit.vessel
        return SecondOrderVessel(vessel.natural_frequency, vessel.damping_ratio, vessel.gain)

    def _fit_vessel(self) -> VesselFit | None:
        """Fit the second-order vessel to the RAO of the boom tip, in this sea, where the parameters ask for it."""
        parameters = self.parameters
        if parameters.vessel.model != "fitted":
            return None
        if self._spectrum is None:
            raise RaoError("vessel.model = fitted needs a sea with a spectrum: boom_tip_source spectrum or filter")
        arm = np.array(parameters.vessel.boom_tip_arm)
        heading = parameters.direction - parameters.course.heading
        speed = parameters.course.speed
        omega = np.linspace(0.4, 3.5, 200) * self._spectrum.peak_frequency
        table = read_rao(parameters.vessel.rao_file, sorted({0.0, speed}))
        return fit_vessel(omega, boom_tip_heave_response(table, omega, heading, speed, arm), self._spectrum)

    def _build_source(self, seed: int, tick_period: float) -> MotionSource:
        """Stack the sources: what moves the vessel, then its course, drift and the ramp."""
        parameters = self.parameters
        source = self._build_wave_source(seed, tick_period)
        if parameters.boom_tip_source in ("spectrum", "filter"):
            source = CourseSource(source, self._course)
        if any(parameters.drift.standard_deviation):
            source = DriftingSource(source, parameters.drift, seed, tick_period)
        return RampedSource(source, parameters, tick_period)

    def _build_wave_source(self, seed: int, tick_period: float) -> MotionSource:
        parameters = self.parameters
        if parameters.boom_tip_source == "regular":
            return RegularSource(parameters.amplitude, parameters.period, tick_period)
        if parameters.boom_tip_source == "file":
            recording = read_recording(parameters.recording_file, parameters.recording_topic)
            self.warnings.extend(recording.warnings)
            is_elevation = parameters.recording_kind == "elevation"
            return RecordedSource(recording, self._second_order_vessel() if is_elevation else None, tick_period)
        assert self._spectrum is not None
        if parameters.boom_tip_source == "filter":
            wave = shaping_filter(self._spectrum, parameters.filter.form, parameters.filter.states)
            return FilterSource(wave, self._second_order_vessel(), seed, tick_period)
        if self._rao is not None:
            arm = np.array(parameters.vessel.boom_tip_arm)
            return RaoSource(self._components(seed), self._rao, self._course, arm, tick_period)
        vessel = self._second_order_vessel()
        return SecondOrderSource(self._components(seed), vessel, parameters.vessel.pitch_gain, tick_period)

    def _read_rao(self) -> ResponseTable | None:
        """Read the table of RAOs where the vessel is one, at the speeds of the course."""
        vessel, course = self.parameters.vessel, self.parameters.course
        if vessel.model != "rao" or self.parameters.boom_tip_source != "spectrum":
            return None
        fastest = max(course.speed, course.speed + course.speed_change)
        speeds = sorted({0.0, course.speed, max(0.0, course.speed + course.speed_change)})
        table = read_rao(vessel.rao_file, speeds)
        if fastest > table.speed[-1] + 1e-9:
            self.warnings.append(
                f"{vessel.rao_file or 'shipped RAO'}: has speeds up to {table.speed[-1]:g} m/s, the course goes to "
                f"{fastest:g} m/s: responses of the highest are taken"
            )
        return table

    def _components(self, seed: int) -> WaveComponents:
        parameters = self.parameters
        assert self._spectrum is not None
        return draw_components(
            self._spectrum,
            parameters.components,
            random_stream(seed, "wave_vessel/sea"),
            direction=parameters.direction,
            spreading_exponent=parameters.spreading.exponent,
        )

    def _build_estimator(self) -> SeaStateEstimator:
        """Make the estimator; it knows the data sheet of the unit and the vessel's response, not the sea."""
        mru = self.parameters.mru

        def unit_response(omega: Array) -> Array:
            if mru.high_pass_period == 0.0:
                return np.ones_like(omega)
            cut_off = 2.0 * math.pi / mru.high_pass_period
            return np.asarray(np.abs(high_pass_response(omega, cut_off, mru.high_pass_damping)) ** 2)

        def vessel_response(omega: Array) -> Array:
            if self._rao is not None:
                return self._boom_tip_response(omega)
            vessel = self._second_order_vessel()
            if vessel is None or self.parameters.boom_tip_source in ("regular", "file"):
                return np.ones_like(omega)
            return np.asarray(np.abs(vessel.response(omega)) ** 2)

        return SeaStateEstimator(
            self.parameters.estimate,
            sample_period=self.mru.reading_period,
            noise=mru.noise,
            unit_response=unit_response,
            vessel_response=vessel_response,
        )

    def _boom_tip_response(self, omega: Array) -> Array:
        """Return |H|^2 from the sea to boom-tip heave of the RAOs, at the first heading and speed."""
        assert self._rao is not None
        course = self.parameters.course
        relative = np.full(omega.shape, self.parameters.direction - course.heading)
        response = self._rao.at(omega, relative, course.speed)
        return np.asarray(np.abs(self._lever[2] @ response) ** 2)
