"""One tick of the loop as a value: what the sensors said, and what is known of all motions. Nothing in it changes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from heave_core.look import Motions
from heave_node.interface.alarm import Alarm
from heave_node.numerics.arrays import Array

from winch_controller_node.core.estimation.tension import NO_MEAN, TensionMean
from winch_controller_node.model.estimator import Innovation
from winch_controller_node.model.loop_rows import LoopRows


def free_swing(heave: float, rate: float, inertia: float) -> float:
    """Return the amplitude [m] of the free swing that a unit makes on its cable.

    Parameters
    ----------
    heave, rate : of the unit [m], [m/s]
    inertia : a of the two-state cable [s^2]
    """
    return math.hypot(heave, math.sqrt(inertia) * rate)


class Sensed(NamedTuple):
    """What the sensors said in a tick, after the gates.

    Attributes
    ----------
    payout : encoder reading, jumps taken off [m]; None: none came
    mru_rate : newest heave rate of the MRU [m/s]; NaN: it measures none
    tension, filtered_tension : newest top tension, and that low-passed [N]; NaN before the first
    depths : depth readings of the tick: stamp [s] and depth, positive down [m]
    depth_heave : the newest of them as heave about the mean payout's share [m]; None: none came
    depth_noise : standard deviation of the depth sensor's noise, as far as it is known [m]
    depth_innovation : its innovation over the standard deviation of that [-]; None: there is none
    has_depth : there is a depth sensor, and it is not lost
    sees_landing : and it does not contradict all others
    has_encoder : a reading of the encoder has been accepted since the start
    innovations : what each reading said against its prediction, by measurement
    lost : why each lost sensor counts as lost, by name
    faults : alarms of sensors that have become worse in this tick
    """

    payout: float | None
    mru_rate: float
    tension: float
    filtered_tension: float
    depths: tuple[tuple[float, float], ...]
    depth_heave: float | None
    depth_noise: float
    depth_innovation: float | None
    has_depth: bool
    sees_landing: bool
    has_encoder: bool
    innovations: Mapping[str, Innovation]
    lost: Mapping[str, str]
    faults: tuple[Alarm, ...]


class CommandShares(NamedTuple):
    """A command in the terms of the model, in two shares: what is `compensating`, and what moves the `mean` payout."""

    compensating: float = 0.0
    mean: float = 0.0

    @property
    def total(self) -> float:
        """The command."""
        return self.compensating + self.mean


class LoopTick(NamedTuple):
    """What is known of the loop at a tick.

    By linearity its motion is the sum of what the mean payout brings about, which is known exactly, and of the rest,
    which is estimated.

    Attributes
    ----------
    number : of the tick
    sensed : after the gates
    rows : of the model whose states these are
    command : active until now
    estimate : state of the loop without the mean payout's own motion, shape (n,)
    mean_state : state that the mean payout alone brings about, shape (n,)
    mean_command : share of the next command that moves the mean payout, in the terms of the model
    left_over : payout left over from before a stop, on its way to the mean [m]
    motions : of boom tip, drum and units
    knows_sea : some waves have been seen
    is_sea_refuted : the sea of the design predicts badly what the motion reference unit reads
    inconsistency : why the readings are not consistent yet; empty where they are
    knows_tip : the boom tip is measured; what is known of it otherwise is not to be acted upon
    mean_tension : at the top, over the waves since the unit and the mean payout are where they are
    missing_push : by how much more the linear model would push the unit down than a slack cable does [m]
    """

    number: int
    sensed: Sensed
    rows: LoopRows
    command: CommandShares
    estimate: Array
    mean_state: Array
    mean_command: float
    left_over: float
    motions: Motions
    knows_sea: bool = True
    is_sea_refuted: bool = False
    inconsistency: str = ""
    knows_tip: bool = True
    mean_tension: TensionMean = NO_MEAN
    missing_push: float = 0.0
