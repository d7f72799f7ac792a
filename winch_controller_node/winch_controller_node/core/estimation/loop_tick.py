"""One tick of the loop as a value: what the sensors said, and what is known of all motions. Nothing in it changes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from heave_node.interface.alarm import Alarm
from heave_node.numerics.arrays import Array

from winch_controller_node.core.estimation.tension import NO_MEAN, TensionMean
from winch_controller_node.model.estimator import Innovation
from winch_controller_node.model.loop_rows import LoopRows


class Motion(NamedTuple):
    """Heave [m] and heave rate [m/s] of a point, positive up."""

    heave: float
    rate: float


def free_swing(motion: Array, inertia: float) -> float:
    """Return the amplitude [m] of the free swing that a unit makes on its cable.

    Parameters
    ----------
    motion : its heave [m] and rate [m/s], shape (2,)
    inertia : a of the two-state cable [s^2]
    """
    heave, rate = motion.tolist()
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


@dataclass(frozen=True)
class LoopTick:
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
    uncompensated : heave [m] and rate [m/s] of the unit with the winch locked, shape (2,)
    taut_uncompensated : the same since compensation began, had the cable been taut for the last seconds, as it is
        once the unit is held
    wave_share : share of the estimated motion of the boom tip that is not noise [-]
    hanging_heave : of a unit that only hangs on its cable, whatever the depth sensor has read of it [m]
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
    uncompensated: Array
    taut_uncompensated: Array
    wave_share: float = 1.0
    hanging_heave: float = 0.0
    knows_sea: bool = True
    is_sea_refuted: bool = False
    inconsistency: str = ""
    knows_tip: bool = True
    mean_tension: TensionMean = NO_MEAN
    missing_push: float = 0.0

    @cached_property
    def total_state(self) -> Array:
        """State of the loop, the mean payout's own motion included, shape (n,)."""
        return self.estimate + self.mean_state

    @cached_property
    def mean_swing(self) -> Array:
        """Heave and rate of the unit about the mean payout that this itself brings about, shape (2,)."""
        rows = self.rows
        return rows.drum(self.mean_state, self.command.mean) + self.mean_state[rows.unit_states]

    @cached_property
    def unit(self) -> Motion:
        """Motion of the unit about where the mean payout would have it at rest: what compensation has left."""
        return Motion(*(self.mean_swing + self.estimate[self.rows.unit_states]).tolist())

    @cached_property
    def free_unit(self) -> Motion:
        """Motion of the unit with the winch locked."""
        return Motion(*self.uncompensated.tolist())

    @cached_property
    def unit_without_compensation(self) -> Motion:
        """Motion of the unit with a winch that does nothing but move the mean payout, as `unit` is counted."""
        return Motion(*(self.uncompensated + self.mean_swing).tolist())

    @property
    def hanging_stretch(self) -> float:
        """By how much the cable would be longer than at rest, did the unit only hang on it [m]."""
        return self.boom_tip.heave - float(self.rows.payout @ self.total_state) - self.hanging_heave

    @cached_property
    def boom_tip(self) -> Motion:
        """Motion of the boom tip."""
        return Motion(*(self.rows.tip @ self.estimate).tolist())

    @property
    def payout(self) -> float:
        """Payout of the drum without that of the mean payout [m]."""
        return float(self.rows.payout @ self.estimate)

    @property
    def payout_rate(self) -> float:
        """Speed of the drum without that of the mean payout [m/s]."""
        return float(self.rows.payout_rate @ self.estimate) + self.rows.payout_rate_through * self.command.compensating

    @property
    def total_payout_rate(self) -> float:
        """Speed of the drum [m/s]."""
        return float(self.rows.payout_rate @ self.total_state) + self.rows.payout_rate_through * self.command.total

    @property
    def measured_unit_heave(self) -> float | None:
        """Heave of the unit as the depth sensor reads it, counted as that of `unit` [m]; None: no reading came."""
        heave = self.sensed.depth_heave
        return None if heave is None else heave + float(self.mean_swing[0])

    @property
    def released_motion(self) -> Array:
        """Heave and rate that the unit is let go to, shape (2,): the uncompensated ones, as far as waves make them.

        What noise of the motion reference unit makes of a lightly damped unit grows to centimetres while the winch
        keeps its uncompensated motion from being measured: in calm water a unit would be swung up to it.
        """
        return self.wave_share * self.uncompensated

    @property
    def unit_offset(self) -> Array:
        """Heave and rate of the unit about its released motion, payout that is out taken off, shape (2,).

        Where the boom tip is not known it is that about rest.
        """
        rows = self.rows
        drum = rows.drum(self.estimate, self.command.compensating)
        offset = self.mean_swing + self.estimate[rows.unit_states] + drum
        return offset - self.released_motion if self.knows_tip else offset
