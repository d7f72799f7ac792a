"""The sea, the vessel and its motion reference unit as one component, stepped by tick number. No ROS."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from heave_node.crane.pose import CranePose
from heave_node.interface.preview import HeavePreview
from heave_node.interface.sensors import MruReading
from heave_node.interface.waves import Waves
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PointMotion, smooth_ramp

from wave_vessel_node.mru.mru import MotionReferenceUnit, high_pass_response
from wave_vessel_node.mru.sea_state_estimate import SeaStateEstimate, SeaStateEstimator
from wave_vessel_node.parameters import WaveVesselParameters
from wave_vessel_node.registries import SOURCES
from wave_vessel_node.sea.sea import SeaState, describe_sea
from wave_vessel_node.sources.layers import ChangingSource, RampedSource, weighted
from wave_vessel_node.sources.motion_source import MotionSource, block_from
from wave_vessel_node.sources.preview import PreviewSource
from wave_vessel_node.sources.scene import Scene, build_scene
from wave_vessel_node.vessel.crane_motion import CraneMotion, PoseSensor
from wave_vessel_node.vessel.fit import VesselFit
from wave_vessel_node.vessel.load_response import LoadResponse
from wave_vessel_node.vessel.motion import VesselMotions, lever_arm_matrix, point_motions

OTHER_WAVES = 1_000_003
"""The waves of a later sea are those of a seed so much higher."""


class WaveVesselOutputs(NamedTuple):
    """What one tick k gives."""

    # the reading delivered at t_k, None if there is none (rate, gap, restart, latency at the start)
    mru: MruReading | None
    boom_tip: PointMotion  # true motion of the boom tip at t_{k+1}, frame world
    vessel: VesselMotions  # true motion of the vessel in a block of ticks
    row: int  # of the block: t_{k+1}
    # a new sea-state estimate from the MRU readings up to t_k, when one is due and the record long enough
    estimate: SeaStateEstimate | None = None
    preview: HeavePreview | None = None  # of the boom tip from t_k on; None: there is none
    crane: tuple[CranePose, ...] = ()  # poses of the crane delivered at t_k

    @property
    def wave_elevation(self) -> float:
        """Sea surface below the boom tip at t_{k+1} [m]."""
        return self.vessel.elevation.item(self.row)


class WaveVessel:
    """Sea state to boom-tip motion, and what the MRU reports of it.

    Parameters
    ----------
    parameters : see WaveVesselParameters
    seed : fixes the sea and the noise
    tick_period : [s]

    Attributes
    ----------
    warnings : what was repaired in the files read
    mru : the motion reference unit, into which faults are injected
    pose_sensor : of the crane, the same; None: there is no crane, or its pose is not measured

    Raises SpectrumError, SpectrumFileError, RaoError or RecordingError when the parameters name something that cannot
    be used.
    """

    def __init__(self, parameters: WaveVesselParameters, *, seed: int, tick_period: float) -> None:
        self.parameters = parameters
        self._scene = build_scene(parameters, seed, tick_period)
        self.warnings = self._scene.warnings
        waves = _waves_of(self._scene)
        self._source = _with_change_and_ramp(waves, self._scene)
        self._lever = lever_arm_matrix(self._scene.boom_tip_arm)
        self._load = None
        if parameters.load_response.displacement > 0.0:
            arm, is_tip = np.array(parameters.vessel.boom_tip_arm), self._scene.rao is None
            self._load = LoadResponse(parameters.load_response, arm, tick_period, is_tip=is_tip)
        self._crane = self._build_crane()
        self.pose_sensor: PoseSensor | None = None
        if self._crane is not None and parameters.crane.pose.fitted:
            self.pose_sensor = PoseSensor(self._crane, parameters.crane.pose, seed=seed, tick_period=tick_period)
        self._sea_state = describe_sea(parameters, self._scene.spectrum, waves.nominal_sea(), seed)
        self.mru = MotionReferenceUnit(parameters.mru, seed=seed, tick_period=tick_period)
        self._estimator = self._build_estimator()
        self._ticks_between_estimates = max(1, round(parameters.estimate.period / tick_period))
        self._next_tick = 1
        self._take_block(1)
        self._preview = self._build_preview() if parameters.preview.time > 0.0 else None

    @property
    def vessel_fit(self) -> VesselFit | None:
        """The vessel identified, where the model is fitted."""
        return self._scene.vessel_fit

    def sea_state(self) -> SeaState:
        """Return the sea as it is published."""
        return self._sea_state

    def waves(self) -> Waves:
        """Return the components of the sea, with its ramp; none where it has none, or none that last."""
        return self._source.waves()

    def initial_boom_tip(self) -> PointMotion:
        """Return the motion of the boom tip at the first tick, from which the plant starts.

        Call it before the first step.
        """
        return self._tip(0)

    def boom_tips(self, count: int) -> list[PointMotion]:
        """Return the motion of the boom tip at the first `count` ticks, as without a load.

        It stands for `step` where no MRU is read.
        """
        tips: list[PointMotion] = []
        while len(tips) < count:
            tips += map(self._tip, range(len(self._tips)))
            self._take_block(len(tips) + 1)
        return tips[:count]

    def step(self, tick: int, tension: float = math.nan) -> WaveVesselOutputs:
        """Return the MRU reading of t_k and the motions of t_{k+1}, k = `tick`; raise ValueError if it is not the next.

        Ticks come in order, from 1. A ship that responds to its load is given the `tension` at the boom tip at t_k [N].
        """
        if tick != self._next_tick:
            raise ValueError(f"ticks must come in order: expected {self._next_tick}, got {tick}")
        reading = self.mru.step(tick)
        poses = () if self.pose_sensor is None else self.pose_sensor.step(tick)
        row = tick + 1 - self._first
        if row == len(self._tips):
            self._take_block(tick + 1, tension)
            row = 0
        self._next_tick = tick + 1
        if reading is not None:
            self._estimator.add(reading)
        estimate = self._estimator.estimate() if tick % self._ticks_between_estimates == 0 else None
        preview = None if self._preview is None else self._preview.step(tick)
        return WaveVesselOutputs(reading, self._tip(row), self._motions, row, estimate, preview, poses)

    def _take_block(self, first: int, tension: float = math.nan) -> None:
        """Compute the motions of a block of ticks from the `first` one on: nothing that happens in a run changes them.

        The readings of the block before have been taken. Of a ship that responds to its load a block is one tick, with
        its answer to the `tension` a tick before [N].
        """
        ticks = block_from(first) if self._load is None else range(first, first + 1)
        self._first, self._motions = first, self._source.motions(ticks)
        if self._load is not None:
            self._motions.six = self._motions.six + self._load.step(tension)
        self._tips = self._points(self._motions)
        seen = self._tips if self._crane is None else self._points_of_mru(self._motions)
        heave = seen[:, :, 2].copy()
        heave[:, 0] -= self.parameters.boom_tip_height
        self.mru.look(self._motions, heave)

    def _tip(self, row: int) -> PointMotion:
        """Return the motion of the boom tip in a `row` of the block."""
        return PointMotion(self._motions.time.item(row), *self._tips[row])

    def _build_crane(self) -> CraneMotion | None:
        crane = self.parameters.crane
        return (
            CraneMotion(crane, self._scene.boom_tip_arm, self.parameters.boom_tip_height) if crane.is_fitted else None
        )

    def _points(self, motions: VesselMotions) -> Array:
        """Return the motion of the boom tip, see `point_motions`."""
        return self._points_of_mru(motions) if self._crane is None else self._crane.points(motions)

    def _points_of_mru(self, motions: VesselMotions) -> Array:
        """Return the motion of the point that the MRU reads: the boom tip in the crane's reference pose."""
        return point_motions(motions, self._lever, self.parameters.boom_tip_height)

    def _build_preview(self) -> PreviewSource:
        """Let the same sea run once more, ahead of this one; sources are asked in the order of their ticks."""
        scene = build_scene(self.parameters, self._scene.seed, self._scene.tick_period)
        ahead = _with_change_and_ramp(_waves_of(scene), scene)
        ahead.motions(range(1, 2))

        def heave_at(ticks: range) -> Array:
            return np.asarray(self._points(ahead.motions(ticks))[:, 0, 2] - self.parameters.boom_tip_height)

        return PreviewSource(
            self.parameters.preview, heave_at, seed=self._scene.seed, tick_period=self._scene.tick_period
        )

    def _build_estimator(self) -> SeaStateEstimator:
        """Make the estimator; it knows the data sheet of the unit and the vessel's response, not the sea."""
        mru = self.parameters.mru

        def unit_response(omega: Array) -> Array:
            if mru.high_pass_period == 0.0:
                return np.ones_like(omega)
            cut_off = 2.0 * math.pi / mru.high_pass_period
            return np.asarray(np.abs(high_pass_response(omega, cut_off, mru.high_pass_damping)) ** 2)

        return SeaStateEstimator(
            self.parameters.estimate,
            sample_period=self.mru.reading_period,
            noise=mru.noise,
            unit_response=unit_response,
            vessel_response=self._scene.power_response,
        )


def boom_tip_heave(parameters: WaveVesselParameters, seed: int, tick_period: float, count: int) -> Array | None:
    """Return heave, heave rate and acceleration of the boom tip at the first `count` ticks, shape (count, 3).

    They are the vertical part of `WaveVessel.boom_tips` by one sum; None where there is none: with a source without
    components, a later sea, a crane, a ship that responds to its load. `parameters`, `seed` and `tick_period` [s] are
    those of a `WaveVessel`.
    """
    scene = build_scene(parameters, seed, tick_period)
    one = _waves_of(scene).point_heave(lever_arm_matrix(scene.boom_tip_arm)[2])
    answers = parameters.load_response.displacement > 0.0
    if one is None or answers or parameters.crane.is_fitted or parameters.later_sea.duration > 0.0:
        return None
    heave, ramp = one.at(range(1, count + 1)), parameters.ramp
    grown = min(math.ceil(ramp / tick_period), count)
    weights = np.array([smooth_ramp(tick * tick_period, ramp) for tick in range(grown)]).reshape(-1, 3)
    heave[:grown] = weighted(heave[:grown], weights)
    return np.asarray(heave[:, :, 0])


def _waves_of(scene: Scene) -> MotionSource:
    source: MotionSource = SOURCES[scene.parameters.boom_tip_source].load()(scene)
    return source


def _with_change_and_ramp(source: MotionSource, scene: Scene) -> MotionSource:
    """Return the motion of a source that goes over into a later sea, on its heading, from rest."""
    parameters = scene.parameters
    later = parameters.later_sea
    if later.duration > 0.0:
        sea = replace(parameters, significant_wave_height=later.significant_wave_height, peak_period=later.peak_period)
        then = _waves_of(build_scene(sea, scene.seed + OTHER_WAVES, scene.tick_period))
        source = ChangingSource(source, then, later.start, later.duration, scene.tick_period)
    heading = parameters.course.heading if scene.spectrum is not None else 0.0
    return RampedSource(source, heading, parameters.ramp, scene.tick_period)
