"""The simulated crane: a programme of moves of its joints, the boom tip that moves with them, and what measures them.

Each move is a quintic ramp, at rest before and after, acceleration continuous, whose largest rate is the parameter's.
"""

from __future__ import annotations

import numpy as np
from heave_node.crane.kinematics import JOINTS, Crane, TipPlace
from heave_node.crane.pose import POSE_FIELDS, CranePose, pose_of_numbers
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PEAK_OF_RAMP, smooth_ramp
from heave_node.sensing.sensor import Sensor

from wave_vessel_node.parameters import CraneMotionParameters, PoseSensorParameters
from wave_vessel_node.vessel.motion import VesselMotions, lever_arm_matrix, point_motions

_OF_JOINTS = np.array([1.0] * len(JOINTS) + [0.0] * len(JOINTS))
"""A spike or jump is an error of the joints, not of their rates."""


class CraneMotion:
    """The crane in a run.

    Parameters
    ----------
    parameters : see CraneMotionParameters
    arm : boom tip in the reference pose from the point whose motion is known [m], shape (3,)
    mean_height : of the boom tip in the reference pose above still water [m]
    """

    def __init__(self, parameters: CraneMotionParameters, arm: Array, mean_height: float) -> None:
        self._parameters = parameters
        self._crane = Crane(parameters)
        self._arm = arm
        self._mean_height = mean_height
        self._ramps = [self._ramps_of(joint) for joint in JOINTS]

    def _ramps_of(self, joint: str) -> list[tuple[float, float, float]]:
        """Return start [s], change [rad], [m] and duration [s] of each move of a `joint`."""
        before, ramps = getattr(self._parameters, joint), []
        for start, target in zip(self._parameters.move_times, getattr(self._parameters, f"move_{joint}"), strict=False):
            change, before = target - before, target
            ramps.append((start, change, PEAK_OF_RAMP * abs(change) / self._parameters.largest_rate(joint)))
        return ramps

    def joints(self, time: float) -> Array:
        """Return the joints at a `time` [s], their rates and accelerations, shape (3, 4)."""
        state = np.zeros((3, len(JOINTS)))
        state[0] = self._parameters.reference
        for joint, ramps in enumerate(self._ramps):
            for start, change, duration in ramps:
                if change != 0.0:
                    state[:, joint] += np.multiply(change, smooth_ramp(time - start, duration))
        return state

    def place(self, time: float) -> TipPlace:
        """Return where the boom tip is in the ship's frame at a `time` [s]."""
        return self._crane.tip(*self.joints(time).tolist())

    def points(self, motions: VesselMotions) -> Array:
        """Return the boom tip's motion in frame world at the times of the vessel's `motions`, see `point_motions`.

        x = s + r + theta x r,  v = s' + r' + theta' x r + theta x r',
        a = s'' + r'' + theta'' x r + 2 theta' x r' + theta x r'', to the first order in the vessel's motion (s, theta),
        as in `point_motions`. The frame's origin stays below the boom tip of the reference pose.
        """
        own = np.array([(one.arm, one.velocity, one.acceleration) for one in map(self.place, motions.time.tolist())])
        lever = np.array([lever_arm_matrix(self._arm + arm) for arm in own[:, 0]])
        turn, turn_rate = motions.six[:, 0, 3:], motions.six[:, 1, 3:]
        acceleration = own[:, 2] + 2.0 * np.cross(turn_rate, own[:, 1]) + np.cross(turn, own[:, 2])
        own[:, 1] += np.cross(turn, own[:, 1])
        own[:, 2] = acceleration
        return point_motions(motions, lever, self._mean_height, own)


class PoseSensor:
    """What measures the pose of a crane: a sensor like all others, whose reading holds all joints and their rates.

    Parameters
    ----------
    crane : that moves
    parameters : of the sensor
    seed, tick_period : of the run; tick_period in [s]

    Attributes
    ----------
    faults : faults may be injected during the run
    """

    def __init__(self, crane: CraneMotion, parameters: PoseSensorParameters, *, seed: int, tick_period: float) -> None:
        self._crane, self._dt = crane, tick_period
        self._sensor = Sensor(
            parameters,
            name="crane",
            node="wave_vessel",
            width=len(POSE_FIELDS),
            seed=seed,
            tick_period=tick_period,
            axes=_OF_JOINTS,
        )
        self.faults = self._sensor.faults

    def step(self, tick: int) -> tuple[CranePose, ...]:
        """Return the poses delivered at `tick`; ticks come in order."""
        truth = self._crane.joints(tick * self._dt)[:2].ravel()
        delivered = self._sensor.step(tick, truth)
        return tuple([pose_of_numbers(reading.time, reading.value.tolist()) for reading in delivered])
