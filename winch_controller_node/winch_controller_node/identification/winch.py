"""The winch as it is: servo, delay, gain and limits, from what it was sent and what its encoder read in a running loop.

Servo and delay look alike at the frequencies of a sea, but not where the winch is at its limits: there the servo's lag
vanishes and the delay stays. Noise in the commands and the winch's limits tell them apart. What is found is used when
it explains the record clearly better than what is in force, so that each change is told once.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from heave_node.interface.codes import WinchLimit
from heave_node.numerics.arrays import Array
from heave_node.numerics.newest import Newest
from numpy.typing import NDArray

from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.identification.drum_fit import (
    ACCELERATIONS,
    BACKLASH,
    CREEP,
    DEADBAND,
    DELAY,
    EXPLAINED,
    GAIN,
    HAULING,
    IMPROVEMENT,
    LAG,
    LIMITS,
    RESOLUTION,
    SPEEDS,
    START_PAYOUT,
    DrumBelief,
    DrumFit,
    DrumRecord,
    best_lags,
    fit_drum,
    proved_belief,
    search_limits,
    told_belief,
    without_needless,
)
from winch_controller_node.identification.drum_kernel import Drum, drum_records, predicted_reading
from winch_controller_node.identification.encoder_scale import Sent
from winch_controller_node.parameters.laws import LagParameters
from winch_controller_node.parameters.model import WinchModelParameters

SHORTEST_RECORD = 4.0
"""Record [s] from which on the winch is identified."""

SIGMAS = Drum(0.05, 0.1, 0.2, 0.02, math.inf, math.inf, math.inf, math.inf, 0.005, hauling=0.2, creep=0.05)
"""How far a drum may well be from the nominal one, 1 sigma; of limits nothing is known."""

SMALLEST_LAG, LARGEST_LAG = 0.005, 2.0
"""Least time constant of a servo, and the most that it is above the nominal one [s]."""

GAINS, LARGEST_DEADBAND, LARGEST_BACKLASH, LOWEST_LIMIT = (0.25, 4.0), 0.2, 0.2, 0.1
"""What a drum can be at all: gain [-], dead zone [m/s], play [m], limits over the nominal ones [-]."""

LARGEST_UNEVENNESS, LARGEST_CREEP = 2.0, 0.2
"""Largest factor between the gains of paying out and hauling in [-], and creep beyond the nominal one [m/s]."""

TELLS_APART = 2.0 * RESOLUTION
"""Servo and delay are told apart by a record that is left with no more than the encoder's resolution [m]."""

EXCHANGED = 100.0
"""By one of which more is left only where the servo differs by so much for each metre of it [s/m]: play in the gear of
the encoder that is not known yet leaves 1 mm and asks for an exchange of 70 ms. A limit that has just been reached, or
lies a little beside the one that was found, asks for any exchange."""

SIGNIFICANT = 4.0
"""A change of lag or delay is taken when it is so many standard deviations off."""

MISFIT = 0.002
"""Limits are searched where so much is left [m]."""

TOLD_MISFIT = 0.0005
"""And where so much is left of a record in which the winch says itself that it has reached one [m]."""

TOLD_WITHIN = 0.15
"""Time before and after a tick in which the winch has reached a limit that shows its direction [s]."""

BETTER = 1.15
"""What is found must leave so many times less, mean square, than what is in force."""

GAIN_STEP, LIMIT_STEP, CREEP_STEP = 0.015, 0.03, 0.001
"""Changes of gains and limits, relative, and of the creep [m/s] that are worth it."""

UNEVEN = 0.1
"""Limits of paying out and hauling in that differ by less are told as one, relative."""

SHARE_LEFT = 0.25
"""Gains and creep of a record that is not explained are believed where they leave no more of what is left now [-]."""

USED = 0.97
"""Share that is used of a limit that was learnt."""

LET_UP = 1.06
"""Limits that were learnt are raised by this factor when they have stood for long."""

FIRST_PATIENCE, LONGER = 120.0, 2.0
"""Time that they stand at first [s], and the factor by which it grows each time that they prove true."""

KINEMATIC = WinchLimit.SPEED | WinchLimit.ACCELERATION | WinchLimit.PAYOUT
"""The others, as of power or pressure, go with the load: no constant one explains them to the millimetre."""

POWER_TIME, STEADY = 0.4, 0.05
"""A speed at which the power ends for so long [s] is a limit, where its halves differ by no more than this share."""

LIMIT_NAMES = tuple(Drum._fields[i] for i in LIMITS)

AS_FOUND = np.array([DEADBAND, BACKLASH, *LIMITS])
"""What of a drum is not that of the model in force."""

CHECKED_TIME = 1.0
"""The drum is compared with its prediction over this time [s]."""

SENT_LEAST = 0.004
"""What the winch was sent and what the encoder read are compared where both have moved so far, 1 sigma [m]."""

SENT_SEEN = 0.8
"""And so many of the readings have come."""

UNSTABLE = 0.15
"""Error of lag and delay together that makes a loop harmful [s]: the delay margins of cables are 0.1 to 0.34 s."""

BORNE_GAIN = 1.25
"""Factor on the gain that a loop bears."""

SETTLED = 5.0
"""Time constants after which a servo has forgotten how it began."""


@dataclass(frozen=True)
class WinchLags:
    """What was found.

    Attributes
    ----------
    drum : servo, delay, gain and limits
    covariance : of time constant and delay, shape (2, 2) [s^2]
    residual : standard deviation of the encoder about the drum's model [m]
    """

    drum: Drum
    covariance: Array
    residual: float

    @property
    def time_constant(self) -> float:
        """Time constant of the servo [s]."""
        return self.drum.lag

    @property
    def delay(self) -> float:
        """Delay of commands [s]."""
        return self.drum.delay

    def is_far_from(self, winch: WinchModelParameters, step: float) -> bool:
        """Tell whether the lags of the model `winch` differ by more than `step` [s], and significantly."""
        off = np.array([self.time_constant - winch.time_constant, self.delay - winch.command_delay])
        return bool(np.max(np.abs(off)) > step and off @ np.linalg.solve(self.covariance, off) > SIGNIFICANT**2)


@dataclass(frozen=True)
class Answer:
    """Fit of the drum as it is believed at `present`, and the best that was `found`; None: the record does not tell."""

    present: DrumFit
    found: DrumFit | None


class WinchIdentifier:
    """Finds servo, delay, gain and limits of a winch with a speed servo.

    Parameters
    ----------
    parameters : length of the record, smallest and largest change
    design : with the nominal winch
    """

    def __init__(self, parameters: LagParameters, design: ControllerDesign) -> None:
        self._parameters = parameters
        self._dt = design.tick_period
        self._nominal = design.parameters.winch
        self._belief = _belief(self._nominal, parameters.largest)
        # a position loop hides what the drive makes of its set-point
        has_loop = self._nominal.position_gain > 0.0
        self._free = (LAG, DELAY) if has_loop else (LAG, DELAY, GAIN)
        self._rare = (BACKLASH,) if has_loop else (DEADBAND, BACKLASH)
        self._uneven = () if has_loop else (HAULING, CREEP)
        self._found = self._belief.nominal.copy()
        self._ahead = math.ceil((self._nominal.command_delay + parameters.largest) / self._dt) + 2
        self._learnt_age, self._patience = 0.0, 0.0
        # limits that did not explain the record that showed them, and those of them since which another gain was found
        self._unproved: set[int] = set()
        self._doubtful: set[int] = set()
        window = max(2, round(parameters.window / self._dt))
        self._payouts, self._rates = Newest(window + self._ahead), Newest(window + self._ahead)
        self._readings = Newest(window)
        self._limits_hit: deque[int] = deque(maxlen=window)
        self.reset()
        # compiled here, not in a tick of a run in real time
        fit_drum(self._made(np.zeros(self._ahead + 3), np.zeros(3)), self._belief, self._start(np.zeros(3)), self._free)
        self._error_after(np.zeros(3), self._nominal)

    def reset(self, payout: float = 0.0) -> None:
        """Begin a new record with the drum at rest at `payout` [m]."""
        self._payouts.clear()
        self._rates.clear()
        self.restart()
        for _ in range(self._ahead):
            self._payouts.append(payout)
            self._rates.append(0.0)

    def restart(self) -> None:
        """Begin a new record with the drum in motion, after something that the model does not know."""
        self._readings.clear()
        self._limits_hit.clear()

    def add(
        self, payout_set_point: float, rate_set_point: float, encoder: float | None, limits_hit: int = WinchLimit.NONE
    ) -> None:
        """Take in a tick.

        Parameters
        ----------
        payout_set_point, rate_set_point : of the tick that ends [m], [m/s]
        encoder : reading at its end [m]; None: no reading
        limits_hit : heave_node.interface.codes.WinchLimit that acted within it, as far as the winch says so
        """
        self._learnt_age += self._dt
        self._payouts.append(payout_set_point)
        self._rates.append(rate_set_point)
        self._readings.append(math.nan if encoder is None else encoder)
        self._limits_hit.append(limits_hit)

    @property
    def is_full(self) -> bool:
        """Tell whether the record has its full length."""
        return self._readings.is_full

    @property
    def lone_directions(self) -> dict[str, str]:
        """Return the direction in which alone a limit was found, by the limit's name in the model of a winch."""
        found = {}
        for name, pair in (("speed_limit", SPEEDS), ("acceleration_limit", ACCELERATIONS)):
            paying_out, hauling_in = (float(self._found[i]) for i in pair)
            if min(paying_out, hauling_in) < (1.0 - UNEVEN) * max(paying_out, hauling_in):
                found[name] = "paying out" if paying_out < hauling_in else "hauling in"
        return found

    def error(self, winch: WinchModelParameters) -> float:
        """Return how far the drum is off where the model `winch` predicted it a second ago [m]; 0 where unknown.

        Payout and rate of then are those that explain the second before it best: at a limit an error of the rate stays.
        """
        count = round(CHECKED_TIME / self._dt)
        if len(self._readings) < 2 * count:
            return 0.0
        readings = self._readings.last(2 * count)
        if not np.isfinite(readings).all():
            return 0.0
        return self._error_after(readings, winch)

    def _error_after(self, readings: Array, winch: WinchModelParameters) -> float:
        """Return how far the last of the `readings` [m] is off what the first half of them and `winch` predict [m]."""
        needed = len(readings) + self._ahead
        payouts, rates = self._payouts.last(needed), self._rates.last(needed)
        drum = self._in_force(winch)
        return float(
            readings[-1]
            - predicted_reading(
                payouts, rates, readings, drum, self._nominal.position_gain, len(readings) // 2, self._dt
            )
        )

    def sent(self, time: float, *, as_found: bool = False) -> Sent | None:
        """Return what the encoder reads of what the winch was sent, did that do as it was told; None: unknown.

        Gain and limits are those that it was believed to have at first: what was learnt of them is learnt of the
        encoder; dead zone and play are as found, for they are made up for in what is sent. All that is compared over a
        `time` [s]. Otherwise all of the winch is `as_found` by now.
        """
        count = round(time / self._dt)
        readings = self._readings.last(count + 1)
        seen = np.isfinite(readings)
        if len(readings) <= count or not seen[0] or np.count_nonzero(seen) < SENT_SEEN * count:
            return None
        kept = [LAG, DELAY, DEADBAND, BACKLASH]
        drum = (self._found if as_found else self._belief.nominal).copy()
        drum[kept] = self._found[kept]
        # a slow servo still goes as it was sent long before: that is known from there on only
        before = min(math.ceil(SETTLED * drum[LAG] / self._dt), len(self._readings) - count - 1)
        begin = self._readings.last(count + 1 + before)[0]
        begin = begin if math.isfinite(begin) else readings[0]
        needed = before + count + 1 + self._ahead
        payouts, rates = self._payouts.last(needed), self._rates.last(needed)
        start = np.array([[begin, self._rate_before(before + count)]])
        path = drum_records(
            payouts, rates, drum[np.newaxis], start, self._nominal.position_gain, before + count, self._dt
        )[0]
        sent, travel = path[before:], path[-1] - (path[before - 1] if before > 0 else begin)
        asked, read = sent[seen[1:]], readings[1:][seen[1:]]
        asked, read = asked - asked.mean(), read - read.mean()
        asked_squares, read_squares = float(asked @ asked), float(read @ read)
        if min(asked_squares, read_squares) < SENT_LEAST**2 * len(read):
            return None
        share = float(asked @ read) / asked_squares
        left = max(read_squares - share**2 * asked_squares, 0.0)
        return Sent(share, math.sqrt(left / read_squares), float(readings[0] + travel))

    def _rate_before(self, count: int) -> float:
        """Return the speed that the winch was sent `count` ticks ago and has reached by now [m/s]."""
        lag = round((self._found[LAG] + self._found[DELAY]) / self._dt)
        return float(self._rates.last(count + 1 + lag)[0])

    def forget(self) -> None:
        """Forget what was learnt, and begin a new record: the encoder was wrong."""
        self._found = self._belief.nominal.copy()
        self._learnt_age = self._patience = 0.0
        self._note_proved(set(LIMITS))
        self.restart()

    def take_back(self, winch: WinchModelParameters) -> None:
        """Forget what the model `winch` does not hold, and begin a new record: the encoder has been wrong lately."""
        limits, self._found = list(LIMITS), np.array(drum_of(winch))
        self._found[limits] = np.minimum(self._found[limits] / USED, self._belief.nominal[limits])
        self._note_proved(set(LIMITS))
        self.restart()

    def find(self) -> WinchLags | None:
        """Return the drum that fits the record best, or None where it does not tell."""
        record = self._record()
        fit = None if record is None else self._fit(record, self._found, self._doubtful)
        return None if fit is None else self._lags(fit)

    def _lags(self, fit: DrumFit) -> WinchLags:
        """Keep what a fit has found, and return it."""
        self._found = fit.drum[:START_PAYOUT].copy()
        return WinchLags(Drum(*self._found.tolist()), fit.covariance, fit.residual)

    def _in_force(self, winch: WinchModelParameters) -> Array:
        """Return the drum of the model `winch`, with limits as they were found: it uses a little less of them."""
        drum = np.array(drum_of(winch))
        drum[AS_FOUND] = self._found[AS_FOUND]
        return drum

    def told_winch(self, winch: WinchModelParameters) -> WinchModelParameters | None:
        """Return the model `winch` with the speed at which the winch says now that its power ends; None: it does not.

        That speed goes with the load, so that no record tells it as fast and as well.
        """
        half = round(0.5 * POWER_TIME / self._dt)
        if len(self._readings) <= 2 * half or any(self._limits_hit[-i] != WinchLimit.POWER for i in range(1, 2 * half)):
            return None
        before, middle, now = self._readings.last(2 * half + 1)[::half].tolist()
        speed, change = (now - before) / (2 * half * self._dt), (now - 2.0 * middle + before) / (half * self._dt)
        index = SPEEDS[0] if speed > 0.0 else SPEEDS[1]
        is_steady = abs(change) < STEADY * abs(speed)  # false where a reading is missing
        if not is_steady or abs(speed) > (1.0 - LIMIT_STEP) * self._found[index]:
            return None
        self._found[index] = max(abs(speed), self._belief.lowest[index])
        self._learnt_age = 0.0
        self._patience = max(self._patience, FIRST_PATIENCE)
        limit = self._limit(Drum(*self._found.tolist()), SPEEDS, winch.speed_limit)
        return None if limit >= winch.speed_limit else replace(winch, speed_limit=limit)

    def improved_winch(self, winch: WinchModelParameters) -> WinchModelParameters | None:
        """Return the winch that was found, or None where the model `winch` does."""
        question = self.question(winch)
        return None if question is None else self.take(question(), winch)

    def question(self, winch: WinchModelParameters) -> Callable[[], Answer] | None:
        """Return the work of looking for a better model than `winch`, longer than a tick; None: it is too early.

        It works on the record as it is now and changes nothing.
        """
        record = self._record()
        if record is None:
            return None
        in_force = self._start(record.readings, self._in_force(winch))
        found, doubtful = self._found.copy(), self._doubtful.copy()
        return lambda: Answer(fit_drum(record, self._belief, in_force, []), self._fit(record, found, doubtful))

    def take(self, answer: Answer, winch: WinchModelParameters) -> WinchModelParameters | None:
        """Return the winch that an `answer` has found, or None where the model `winch` in force does."""
        before = self._found
        found = None if answer.found is None else self._lags(answer.found)
        better = None if found is None else self._believed(winch, found, answer.present)
        is_refuted = any(self._found[i] > before[i] for i in self._doubtful)
        if found is not None and found.residual <= TELLS_APART:
            self._note_proved({i for i in self._doubtful if self._found[i] == before[i]})
        if (
            found is None
            or better is None
            or not (is_refuted or self._is_worth_it(winch, better, answer.present, found))
        ):
            self._found[list(LIMITS)] = before[list(LIMITS)]
            return self._let_up(winch)
        if found.residual > EXPLAINED:
            # gains and creep alone are believed
            self._found[list(LIMITS)] = before[list(LIMITS)]
        self._note_unproved(before, found.residual, has_other_gain=better.speed_gain != winch.speed_gain)
        if is_weaker(better, winch):
            self._patience = FIRST_PATIENCE if self._patience == 0.0 else LONGER * self._patience
            self._learnt_age = 0.0
        return better

    def _note_unproved(self, before: Array, residual: float, *, has_other_gain: bool) -> None:
        """Note which limits, other than `before`, do not explain a record of which a `residual` [m] is left."""
        moved = {i for i in LIMITS if self._found[i] != before[i]}
        self._note_proved(moved)
        if residual > TELLS_APART:
            self._unproved |= {i for i in moved if self._found[i] < self._belief.nominal[i]}
        if has_other_gain:
            # what changes within a record, winch or encoder, looks as if the winch had reached a limit
            self._doubtful = self._unproved.copy()

    def _note_proved(self, limits: set[int]) -> None:
        """Note that nothing speaks against these `limits` any more."""
        self._unproved -= limits
        self._doubtful -= limits

    def _believed(self, winch: WinchModelParameters, found: WinchLags, present: DrumFit) -> WinchModelParameters | None:
        """Return the model `winch` with what is believed of what was found; None: nothing is."""
        better = self._with(winch, found)
        if found.residual <= EXPLAINED:
            return better
        is_power_limited = any(hit & WinchLimit.POWER for hit in self._limits_hit)
        if is_power_limited or found.residual > SHARE_LEFT * present.residual:
            return None  # a limit that goes with the load looks like other gains out and in
        # what is left may well look like a limit or a lag, but most of the record is explained by gains and creep
        return replace(winch, speed_gain=better.speed_gain, hauling_gain=better.hauling_gain, creep=better.creep)

    def _with(self, winch: WinchModelParameters, found: WinchLags) -> WinchModelParameters:
        """Return the model `winch` with what was found and differs clearly."""
        better = replace(
            winch,
            speed_gain=found.drum.gain,
            speed_limit=self._limit(found.drum, SPEEDS, winch.speed_limit),
            acceleration_limit=self._limit(found.drum, ACCELERATIONS, winch.acceleration_limit),
        )
        lag, delay = self._lags_told(winch, found)
        step = self._parameters.step
        is_far = max(abs(lag - winch.time_constant), abs(delay - winch.command_delay)) > step
        if is_far and found.is_far_from(winch, step):
            better = replace(better, time_constant=lag, command_delay=delay)
        hauling, creep = found.drum.hauling, found.drum.creep
        if abs(hauling / winch.hauling_gain - 1.0) >= GAIN_STEP or abs(creep - winch.creep) >= CREEP_STEP:
            # the three explain a record together
            return replace(better, hauling_gain=hauling, creep=creep)
        if abs(better.speed_gain / winch.speed_gain - 1.0) < GAIN_STEP:
            better = replace(better, speed_gain=winch.speed_gain)
        return better

    def _lags_told(self, winch: WinchModelParameters, found: WinchLags) -> tuple[float, float]:
        """Return time constant and delay [s]: as found, or their sum alone, with the time constant of the `winch`."""
        has_reached_a_limit = bool(self._belief.lowered(np.array(found.drum)))
        change = abs(found.time_constant - winch.time_constant)
        is_told_apart = not has_reached_a_limit and change > EXCHANGED * found.residual
        if found.residual <= TELLS_APART or is_told_apart:
            return found.time_constant, found.delay
        together = found.time_constant + found.delay
        delay, shortest = together - winch.time_constant, float(self._belief.lowest[DELAY])
        return (winch.time_constant, delay) if delay >= shortest else (together - shortest, shortest)

    @staticmethod
    def _is_worth_it(
        winch: WinchModelParameters, better: WinchModelParameters, present: DrumFit, found: WinchLags
    ) -> bool:
        """Tell whether a change explains the record clearly better; a weaker winch is always believed."""
        if better == winch:
            return False
        floor = RESOLUTION**2 * present.count
        return is_weaker(better, winch) or present.squares + floor > BETTER * (
            found.residual**2 * present.count + floor
        )

    def _let_up(self, winch: WinchModelParameters) -> WinchModelParameters | None:
        """Trust the winch with a little more when limits that were learnt have stood for long: false ones heal so."""
        learnt = Drum(*self._found.tolist())
        nominal = Drum(*self._belief.nominal.tolist())
        if self._learnt_age < self._patience or all(self._found[list(LIMITS)] >= self._belief.nominal[list(LIMITS)]):
            return None
        self._learnt_age = 0.0
        raised = {name: min(LET_UP * getattr(learnt, name), getattr(nominal, name)) for name in LIMIT_NAMES}
        self._found = np.array(learnt._replace(**raised))
        drum = Drum(*self._found.tolist())
        return replace(
            winch,
            speed_limit=self._limit(drum, SPEEDS, winch.speed_limit),
            acceleration_limit=self._limit(drum, ACCELERATIONS, winch.acceleration_limit),
        )

    def _limit(self, drum: Drum, pair: tuple[int, int], in_force: float) -> float:
        """Return the limit to use: that of the weaker direction."""
        nominal = float(min(self._belief.nominal[i] for i in pair))
        weaker = min(drum[i] for i in pair)
        limit = nominal if weaker >= nominal else USED * weaker
        return in_force if abs(limit / in_force - 1.0) < LIMIT_STEP else limit

    def _fit(self, record: DrumRecord, found: Array, doubtful: set[int]) -> DrumFit | None:
        belief = told_belief(record, proved_belief(record, self._belief), found)
        start = self._start(record.readings, np.maximum(found, belief.lowest))
        learnt: list[int] = []
        taken: list[int] = []
        for pair in (SPEEDS, ACCELERATIONS):
            weaker = min(start[i] for i in pair)
            if weaker < belief.nominal[pair[0]]:
                # a direction that has not reached its limit yet is taken for no stronger than the other
                unreached = [i for i in pair if start[i] >= belief.nominal[i]]
                start[unreached] = np.maximum(weaker, belief.lowest[unreached])
                learnt += pair
                taken += unreached
        known = [i for i in (*self._rare, *self._uneven) if start[i] != belief.nominal[i]]
        free = [*self._free, *known]
        fit = fit_drum(record, belief, start, free)
        misfit = TOLD_MISFIT if record.told else MISFIT
        # limits that were learnt stay where they explain the record: what is not reached tells nothing
        likely = [] if fit.residual <= misfit else best_lags(record, belief, start)
        for other in [start, *likely] if likely else []:
            again = fit_drum(record, belief.near(other), other, [*free, *learnt])
            again = without_needless(record, belief, again, free, start, learnt)
            fit = again if IMPROVEMENT * again.squares < fit.squares else fit
        believed = start.copy()
        believed[list(self._free)] = belief.nominal[list(self._free)]
        # lag and delay that explained a limit badly lead nowhere, and those of a far slower winch may have reached one
        for begin in (start, believed, *likely):
            if fit.residual > misfit:
                limited = search_limits(record, belief.near(begin), begin, free, learnt)
                fit = limited if limited.squares < fit.squares else fit
        if fit.residual > misfit and not set(self._rare) <= set(free):
            fit = self._with_rare(record, belief, fit, start, learnt)
        # a limit that goes with the load looks like other gains out and in
        if fit.residual > misfit and not record.is_load_limited and not set(self._uneven) <= set(free):
            fit = self._with_uneven(record, belief, fit)
        if fit.residual <= misfit:
            fit = self._without_refuted(record, belief, fit, doubtful - set(record.told), free)
        # what was only taken from the other direction is not known: it goes with that again the next time
        unproved = [i for i in taken if fit.drum[i] == start[i]]
        fit.drum[unproved] = belief.nominal[unproved]
        return fit if np.all(np.isfinite(fit.drum)) else None

    @staticmethod
    def _without_refuted(
        record: DrumRecord, belief: DrumBelief, fit: DrumFit, doubtful: set[int], free: Sequence[int]
    ) -> DrumFit:
        """Return the fit of an explained record without those of the `doubtful` limits that it does not need."""
        for index in sorted(doubtful):
            start = fit.drum.copy()
            start[index] = belief.nominal[index]
            other = fit_drum(record, belief, start, free)
            fit = other if other.squares < IMPROVEMENT * fit.squares else fit
        return fit

    def _with_rare(
        self, record: DrumRecord, belief: DrumBelief, fit: DrumFit, otherwise: Array, known: Sequence[int]
    ) -> DrumFit:
        """Return a fit with dead zone and play where the record is much better explained by them."""
        free, lowered = [*self._free, *self._rare], belief.lowered(fit.drum)
        nominal = self._start(record.readings, belief.nominal)
        nominal[list(LIMITS)] = fit.drum[list(LIMITS)]
        found = [fit_drum(record, belief, start, [*free, *lowered]) for start in (fit.drum, nominal)]
        best = min(found, key=lambda other: other.squares)
        best = without_needless(record, belief, best, free, otherwise, known)
        return best if IMPROVEMENT * best.squares < fit.squares else fit

    def _with_uneven(self, record: DrumRecord, belief: DrumBelief, fit: DrumFit) -> DrumFit:
        """Return a fit with a creep, and another gain out than in, where the record is much better explained by them.

        Limits are searched anew: a limit explains some of what a gain that is too low leaves.
        """
        free = [*self._free, *self._uneven]
        start = self._start(record.readings, belief.nominal)
        found = fit_drum(record, belief, start, free)
        if found.residual > MISFIT:
            found = min(found, search_limits(record, belief, found.drum, free, ()), key=lambda other: other.squares)
        return found if IMPROVEMENT * found.squares < fit.squares else fit

    def _record(self) -> DrumRecord | None:
        readings = self._readings.last().copy()
        seen = np.isfinite(readings)
        if len(readings) * self._dt < SHORTEST_RECORD or np.count_nonzero(seen) < len(readings) // 2:
            return None
        return self._made(self._rates.last(), readings)

    def _made(self, rates: Array, readings: Array) -> DrumRecord:
        payouts = self._payouts.last().copy() if len(self._payouts) == len(rates) else np.zeros(len(rates))
        limits_hit = np.zeros(len(readings), dtype=np.int64)
        if len(self._limits_hit) == len(readings):
            limits_hit[:] = self._limits_hit
        is_load_limited = bool(np.any(limits_hit & ~int(KINEMATIC)))
        told = () if is_load_limited else self._told(limits_hit, readings)
        gain = self._nominal.position_gain
        return DrumRecord(payouts, rates.copy(), readings, gain, self._dt, told, is_load_limited)

    def _told(self, limits_hit: NDArray[np.int64], readings: Array) -> tuple[int, ...]:
        """Return the limits of which the winch says that it has reached them.

        Limits of speed and acceleration are those of the direction in which the encoder went.
        """
        ahead = math.ceil(TOLD_WITHIN / self._dt)
        hit = limits_hit[ahead : len(limits_hit) - ahead]
        before, now, after = readings[: -2 * ahead], readings[ahead:-ahead], readings[2 * ahead :]
        told = []
        for pair, limit, moved in (
            (SPEEDS, WinchLimit.SPEED, after - before),
            (ACCELERATIONS, WinchLimit.ACCELERATION, after - 2.0 * now + before),
        ):
            directions = moved[(hit & limit) != 0]
            told += [index for index, sign in zip(pair, (1.0, -1.0), strict=True) if np.any(sign * directions > 0.0)]
        return tuple(told)

    def _start(self, readings: Array, drum: Array | None = None) -> Array:
        """Return a drum with payout and rate at the start of the record, shape (14,)."""
        first = readings[np.isfinite(readings)][0]
        return np.array([*(self._found if drum is None else drum), first, 0.0])


def drum_of(winch: WinchModelParameters) -> Drum:
    """Return the drum of a model of the winch."""
    speed, acceleration = winch.speed_limit, winch.acceleration_limit
    return Drum(
        lag=winch.time_constant,
        delay=winch.command_delay,
        gain=winch.speed_gain,
        hauling=winch.hauling_gain,
        creep=winch.creep,
        speed_out=speed,
        speed_in=speed,
        acceleration_out=acceleration,
        acceleration_in=acceleration,
        reach=winch.set_point_reach,
    )


def is_weaker(one: WinchModelParameters, other: WinchModelParameters) -> bool:
    """Tell whether a limit of `one` is lower than that of `other`."""
    return one.speed_limit < other.speed_limit or one.acceleration_limit < other.acceleration_limit


def lags_otherwise(one: WinchModelParameters, other: WinchModelParameters) -> bool:
    """Tell whether lag and delay of `one` differ so much from those of `other` that no loop bears it."""
    return abs(one.time_constant + one.command_delay - other.time_constant - other.command_delay) > UNSTABLE


def gains_otherwise(one: WinchModelParameters, other: WinchModelParameters) -> bool:
    """Tell whether the gain of `one` differs so much from that of `other` that no loop bears it."""
    return abs(math.log(one.speed_gain / other.speed_gain)) > math.log(BORNE_GAIN)


def _belief(winch: WinchModelParameters, largest: float) -> DrumBelief:
    """Return what is believed of a drum at first; lag and delay change by `largest` [s] at most."""
    nominal = drum_of(winch)
    limits = {name: LOWEST_LIMIT * getattr(nominal, name) for name in LIMIT_NAMES}
    lowest = nominal._replace(
        lag=SMALLEST_LAG,
        delay=max(nominal.delay - largest, 0.0),
        gain=GAINS[0],
        hauling=nominal.hauling / LARGEST_UNEVENNESS,
        creep=nominal.creep - LARGEST_CREEP,
        **limits,
    )
    highest = nominal._replace(
        lag=nominal.lag + LARGEST_LAG,
        delay=nominal.delay + largest,
        gain=GAINS[1],
        deadband=LARGEST_DEADBAND,
        backlash=LARGEST_BACKLASH,
        hauling=nominal.hauling * LARGEST_UNEVENNESS,
        creep=nominal.creep + LARGEST_CREEP,
    )
    return DrumBelief(*(np.array(drum) for drum in (nominal, SIGMAS, lowest, highest)))
