"""Which sensor is not what it is believed to be, or the cable: the last minute is estimated anew under each suspicion.

Each sensor tells something of the same motions, so that an estimator that believes in a wrong one foresees badly what
all of them read. The suspicion under which the readings of a minute are by far the likeliest, and as far off as
foreseen, names what is at fault. Where none explains it, two may be wrong: a high-pass of the MRU and the inertia of
the cable are then tried together, as either of them alone leaves what the other does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import detrend

from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.estimation.reading_record import ENCODER_ROW, ReadingRecord
from winch_controller_node.interface.sensors import MRU_BIAS, MRU_SCALE, KnownSensors
from winch_controller_node.model.estimator import KalmanEstimator, Measurement, RecordedTick, begin_anew
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import SeaModelParameters

CABLE = "cable"
"""Culprit that is no sensor."""

SETTLING = 15.0
"""Time at the start of the record over which a suspicion is not judged: its estimate settles [s]."""

CORNERS = (100.0, 60.0, 40.0, 30.0, 22.0, 16.0)
"""Cut-off periods of an MRU's high-pass that are tried [s]."""

OTHER_CORNER = 1.1
"""One that differs by less than this factor from the believed one is not worth telling."""

REFINEMENTS = (1.12, 1.05, 1.02)
"""Factors, up and down, by which the best of them is then refined."""

COARSE = 1.25
"""And before these, where two are wrong: the best corner of one that is tried alone is farther off."""

DAMPING_POWER = 6
"""Damping is changed by the power of these factors: a record tells it so much worse than inertia."""

SCALE_SIGMA = 0.2
"""Error of scale between MRU and drum that is tried, 1 sigma: the estimate finds how large it is."""

RIGHT_SCALE = 0.02
"""Error of scale below which a sensor is as believed."""

BIAS_SIGMA = 1.0
"""Mean of the MRU's heave that is tried, 1 sigma [m]: the estimate finds how large it is."""

WANDERS = (0.005, 0.015)
"""Random walks of one that wanders within minutes that are tried [m/sqrt(s)]."""

WANDERED = 0.1
"""Error of one that wanders from which on it is told [m]: what something else has left looks like a smaller one."""

LIKELY_ERRORS = {MRU_SCALE: (-0.7, 1.5), MRU_BIAS: (-math.inf, math.inf)}
"""And the errors that are one, by state: a sensor with the wrong sign, or none, has another fault than its scale."""

LARGEST_NIS = 50.0
"""What one normalised innovation counts at most."""

INERTIAS, DAMPINGS = (0.65, 0.8, 0.9, 1.1, 1.25, 1.5), (4.0,)
"""Inertias and dampings of the cable that are tried, over those believed."""

EXPLAINED = 4.0
"""Largest mean of normalised innovations squared, of any measurement, under a suspicion that holds; 1 if it is true."""

LESS = 0.6
"""And no more of what it is without the suspicion: what is at fault explains most of the surprise."""

SHARE_LEFT = 0.25
"""Or largest share of it that a wrong sensor leaves: a unit that swings by metres is not foreseen to a centimetre.

The cable is held to the first: the drag of such a swing looks like a cable that is damped otherwise.
"""

TELLING = 3.0
"""Motion over the noise of a sensor, standard deviations, in which it shows its sign and scale."""

CLEARLY = 100.0
"""A suspicion holds if it makes the record likelier by a factor of exp(CLEARLY) at least, than no and any other."""


@dataclass(frozen=True)
class Suspicion:
    """Something that may be wrong.

    Attributes
    ----------
    culprit : the sensor, or the cable; empty: none; the cable may be wrong besides a sensor
    words : what is wrong with it
    parameters : what is to be believed then
    doubted : sensor whose readings count as noise; empty: none
    cable : inertia and damping of the cable over those believed
    state : error of a sensor that is estimated, and told in the words once it is known; empty: none
    least_error : smallest one with which it holds
    is_acquittal : that error is none: a sensor that was wrong is as believed again
    """

    culprit: str
    words: str
    parameters: WinchControllerParameters
    doubted: str = ""
    cable: tuple[float, float] = (1.0, 1.0)
    state: str = ""
    least_error: float = 0.0
    is_acquittal: bool = False

    @property
    def is_high_pass(self) -> bool:
        """Tell whether it is one of the MRU."""
        return self.culprit == "mru" and not (self.doubted or self.state)

    @property
    def is_explanation(self) -> bool:
        """Tell whether it says what is wrong, and not only where."""
        return bool(self.culprit) and not self.doubted

    @property
    def findings(self) -> dict[str, str]:
        """Return what is wrong with each that is at fault, by culprit."""
        found = {self.culprit: self.words} if self.culprit else {}
        return found if self.cable == (1.0, 1.0) else found | {CABLE: _cable_words(*self.cable)}


@dataclass(frozen=True)
class Verdict:
    """The likeliest suspicion.

    Attributes
    ----------
    suspicion : that holds
    design : for it
    estimator : that has gone through the record under it
    last : number of the last tick that it knows
    """

    suspicion: Suspicion
    design: ControllerDesign
    estimator: KalmanEstimator
    last: int


Designer = Callable[[WinchControllerParameters, tuple[float, float]], ControllerDesign]


def suspect(
    parameters: WinchControllerParameters,
    record: Sequence[RecordedTick],
    design_for: Designer,
    tick_period: float,
    *,
    doubted: str = "",
    scale: float | None = None,
    first_sea: SeaModelParameters | None = None,
) -> Verdict:
    """Return the likeliest suspicion of a `record`: that all is as believed, where no other is clearly likelier.

    Parameters
    ----------
    parameters : believed
    record : of a minute
    design_for : designs for parameters, and for inertia and damping of the cable over those believed
    tick_period : [s]
    doubted : sensor that is until it clearly agrees with all others; of a unit that is held at rest none tells its sign
    scale : error of the MRU's scale that has been found; None: it is not followed
    first_sea : that was believed before any was seen: a mean of the heave is taken for a swell; None: the same
    """
    first_judged = record[0].number + round(SETTLING / tick_period)

    witnesses = _witnesses(record)

    def tried(suspicion: Suspicion, known_scale: float | None = None) -> _Trial:
        sensors = suspicion.parameters.sensors
        use = (*sensors.use, *(name for name in witnesses if name not in sensors.use))
        design = design_for(replace(suspicion.parameters, sensors=replace(sensors, use=use)), suspicion.cable)
        return _tried(suspicion, design, record, first_judged, known_scale)

    def refined(trials: Sequence[_Trial], factors: Sequence[float]) -> _Trial:
        best = _likeliest(trials)
        for factor in factors:
            best = _likeliest([best, *(tried(near) for near in _near(parameters, best.verdict.suspicion, factor))])
        return best

    nothing = tried(Suspicion("", "", parameters), scale)
    trials = [tried(suspicion) for suspicion in _suspicions(parameters, first_sea or parameters.sea)]
    best = refined(trials, REFINEMENTS)
    found = best if _explains(best, nothing, parameters) and best.likelihood > nothing.likelihood + CLEARLY else nothing
    if found is nothing or found.verdict.suspicion.doubted:
        # what wanders explains a little of everything: it is asked last, and has to explain all
        wandering = map(tried, _wandering_biases(parameters, first_sea or parameters.sea))
        last = _likeliest([found, *(trial for trial in wandering if _is_enough(trial, parameters))])
        found = last if last.likelihood > found.likelihood + CLEARLY else found
    if found is nothing and doubted:
        left_out = next(trial for trial in trials if trial.verdict.suspicion.doubted == doubted)
        found = nothing if _agrees(doubted, nothing, left_out) else left_out
    filtered = [trial for trial in trials if trial.verdict.suspicion.is_high_pass]
    if not filtered or _is_enough(found, parameters):
        return found.verdict
    one = _likeliest(filtered).verdict.suspicion
    both = refined([tried(replace(one, cable=(inertia, 1.0))) for inertia in INERTIAS], (COARSE, *REFINEMENTS))
    # of a sensor that is doubted nothing is foreseen: it is no measure
    before = nothing if found.verdict.suspicion.doubted else found
    likeliest = _likeliest([best, nothing])
    holds = _explains(both, before, parameters) and both.likelihood > likeliest.likelihood + CLEARLY
    return (both if holds else found).verdict


def _likeliest(trials: Sequence[_Trial]) -> _Trial:
    """Return that of the `trials` under which the record is likeliest."""
    return max(trials, key=lambda trial: trial.likelihood)


def _explains(trial: _Trial, before: _Trial, parameters: WinchControllerParameters) -> bool:
    """Tell whether the sensors in use are foreseen under a suspicion, and those that only witness no worse for it.

    Parameters
    ----------
    trial, before : of the suspicion, and of none or a simpler one
    parameters : believed
    """
    unexplained = before.worst(parameters, are_used=True)
    allowed = min(EXPLAINED, LESS * unexplained)
    if set(trial.verdict.suspicion.findings) <= set(parameters.sensors.use):
        allowed = max(allowed, SHARE_LEFT * unexplained)
    witnessed = max(EXPLAINED, before.worst(parameters, are_used=False))
    is_witnessed = trial.worst(parameters, are_used=False) <= witnessed
    return trial.worst(parameters, are_used=True) < allowed and is_witnessed


def _agrees(sensor: str, nothing: _Trial, left_out: _Trial) -> bool:
    """Tell whether a `sensor` is foreseen where it is believed, and has something to tell.

    Parameters
    ----------
    sensor : that is doubted
    nothing, left_out : with all sensors believed, and without this one
    """
    rows = [row for row in KnownSensors().by_name()[sensor].rows() if row.name in left_out.motions]
    is_foreseen = all(nothing.misfits.get(row.name, 0.0) < EXPLAINED for row in rows)
    return is_foreseen and any(left_out.motions[row.name] > TELLING * row.sigma for row in rows)


def _is_enough(found: _Trial, parameters: WinchControllerParameters) -> bool:
    """Tell whether what was `found` says what is wrong, so that the sensors in use (`parameters`) are foreseen."""
    return found.verdict.suspicion.is_explanation and found.worst(parameters, are_used=True) < EXPLAINED


def likelihood(design: ControllerDesign, record: Sequence[RecordedTick], tick_period: float) -> float:
    """Return the logarithm of the likelihood of a `record` of ticks, `tick_period` [s] apart, under a `design`.

    Its start is not judged.
    """
    first_judged = record[0].number + round(SETTLING / tick_period)
    return _tried(Suspicion("", "", design.parameters), design, record, first_judged).likelihood


def continued(verdict: Verdict, record: ReadingRecord) -> KalmanEstimator:
    """Return the estimator of a `verdict` after the ticks of `record` that have come since."""
    since = record.ticks(verdict.last)
    doubted = verdict.suspicion.doubted
    verdict.estimator.follow(_without(doubted, since) if doubted else since)
    return verdict.estimator


def _witnesses(record: Sequence[RecordedTick]) -> list[str]:
    """Return the sensors whose readings are on `record`."""
    read = {reading.name for tick in record for reading in tick.readings}
    sensors = KnownSensors().by_name()
    return [name for name, sensor in sensors.items() if any(row.name in read for row in sensor.rows())]


def _cut_offs(parameters: WinchControllerParameters, periods: Sequence[float]) -> list[Suspicion]:
    """Return the suspicions of those `periods` [s] that differ from the believed one."""
    before = parameters.sensors.mru.high_pass_period
    was = f"{before:g} s" if before > 0.0 else "none"
    words = "its heave has a high-pass with a cut-off period of {:.0f} s (believed: {})"
    return [
        Suspicion("mru", words.format(period, was), _with_mru(parameters, high_pass_period=period))
        for period in periods
        if before == 0.0 or abs(math.log(period / before)) > math.log(OTHER_CORNER)
    ]


def _with_mru(parameters: WinchControllerParameters, **believed: float) -> WinchControllerParameters:
    """Return `parameters` in which something else is `believed` of the MRU, by name."""
    sensors = parameters.sensors
    return replace(parameters, sensors=replace(sensors, mru=replace(sensors.mru, **believed)))


def _scale(parameters: WinchControllerParameters) -> Suspicion:
    # a drum whose rope is wound on another radius than believed leaves as much of the motion
    words = "the heave that the one reads is {times:.2f} times what payout and depth make of it"
    return Suspicion("mru or drum", words, _with_mru(parameters, scale_sigma=SCALE_SIGMA), state=MRU_SCALE)


def _bias(parameters: WinchControllerParameters) -> Suspicion:
    words = "its heave has a mean of {error:+.2f} m, which is taken off"
    return Suspicion("mru", words, _with_mru(parameters, bias_sigma=BIAS_SIGMA), state=MRU_BIAS)


def _wandering_biases(parameters: WinchControllerParameters, first_sea: SeaModelParameters) -> list[Suspicion]:
    words = "its heave wanders, as in a turn, and is {error:+.2f} m off now, which is taken off"
    sensors, before_waves = parameters.sensors, replace(parameters, sea=first_sea)
    return [
        Suspicion(
            "mru",
            words,
            _with_mru(before_waves, bias_sigma=BIAS_SIGMA, bias_drift=drift),
            state=MRU_BIAS,
            least_error=WANDERED,
        )
        for drift in WANDERS
        if "mru" in sensors.use and drift > sensors.mru.bias_drift
    ]


def _cable(parameters: WinchControllerParameters, inertia: float, damping: float) -> Suspicion:
    return Suspicion(CABLE, _cable_words(inertia, damping), parameters, cable=(inertia, damping))


def _cable_words(inertia: float, damping: float) -> str:
    return f"it answers with {inertia:.2f} times the inertia and {damping:.2g} times the damping that are believed"


def _suspicions(parameters: WinchControllerParameters, first_sea: SeaModelParameters) -> list[Suspicion]:
    """Return what may be wrong with the sensors in use, and with the cable; the sea that is seen may be none."""
    sensors = parameters.sensors
    # of a heave that wanders nothing tells a high-pass
    has_mean = "mru" in sensors.use and sensors.mru.bias_drift < min(WANDERS)
    found = _cut_offs(parameters, CORNERS) if has_mean else []
    # one that is followed already may have changed since, and is found slowly
    if "mru" in sensors.use and sensors.mru.scale_sigma <= SCALE_SIGMA:
        found.append(_scale(parameters))
    if "mru" in sensors.use and sensors.mru.bias_sigma == 0.0:
        found.append(_bias(parameters))
        if parameters.sea != first_sea:
            found.append(_bias(replace(parameters, sea=first_sea)))
    found += [_cable(parameters, inertia, 1.0) for inertia in INERTIAS]
    found += [_cable(parameters, 1.0, damping) for damping in DAMPINGS]
    found += [
        Suspicion(name, "its readings contradict all others", parameters, doubted=name)
        for name in sensors.use
        if name != "encoder"
    ]
    return found


def _near(parameters: WinchControllerParameters, suspicion: Suspicion, factor: float) -> list[Suspicion]:
    """Return the neighbours of a suspicion that has a size, by a factor above and below it."""
    if suspicion.doubted or suspicion.state:
        return []
    inertia, damping = suspicion.cable
    if suspicion.culprit == CABLE:
        more = factor**DAMPING_POWER
        changes = [(factor, 1.0), (1.0 / factor, 1.0), (1.0, more), (1.0, 1.0 / more)]
        return [_cable(parameters, inertia * mass, damping * drag) for mass, drag in changes]
    corner = suspicion.parameters.sensors.mru.high_pass_period
    near = [
        replace(other, cable=suspicion.cable) for other in _cut_offs(parameters, (corner * factor, corner / factor))
    ]
    if CABLE not in suspicion.findings:
        return near
    return [*near, *(replace(suspicion, cable=(mass, damping)) for mass in (inertia * factor, inertia / factor))]


@dataclass(frozen=True)
class _Trial:
    """A suspicion that was tried.

    Attributes
    ----------
    likelihood : logarithm of that of the record
    misfits : mean of the normalised innovations squared of each measurement
    motions : standard deviation of what each measurement is foreseen to read, where that moves least
    verdict : if it holds
    """

    likelihood: float
    misfits: Mapping[str, float]
    motions: Mapping[str, float]
    verdict: Verdict

    def worst(self, parameters: WinchControllerParameters, *, are_used: bool) -> float:
        """Return the largest misfit of the sensors that `parameters` use, or of those that only witness."""
        used = {row.name for sensor in parameters.sensors.in_use().values() for row in sensor.rows()}
        return max((misfit for name, misfit in self.misfits.items() if (name in used) == are_used), default=1.0)


def _tried(
    suspicion: Suspicion,
    design: ControllerDesign,
    record: Sequence[RecordedTick],
    first_judged: int,
    scale: float | None = None,
) -> _Trial:
    """Go through a `record` under a `suspicion`, judging readings from a tick on; the MRU's `scale` may be known."""
    estimator = design.make_estimator()
    if scale is not None:
        _know_scale(estimator, design.model.state(MRU_SCALE), scale)
    likelihood = 0.0
    squares: dict[str, list[float]] = {}
    foreseen: dict[str, list[float]] = {}
    followed = estimator.follow(_with_doubt(suspicion.doubted, record))
    for tick, innovations in zip(record, followed, strict=True):
        if tick.number < first_judged:
            continue
        read = {reading.name: reading.value for reading in tick.readings}
        for name, innovation in innovations.items():
            if math.isfinite(innovation.nis):
                foreseen.setdefault(name, []).append(read[name] - innovation.value)
                nis = min(innovation.nis, LARGEST_NIS)
                likelihood -= 0.5 * nis + math.log(innovation.sigma)
                squares.setdefault(name, []).append(nis)
    # the winch is identified by the encoder, which is right where the model of the winch is not
    misfits = {name: float(np.mean(values)) for name, values in squares.items() if name != ENCODER_ROW}
    if suspicion.state:
        error = float(estimator.estimate[design.model.state(suspicion.state)])
        words = suspicion.words.format(error=error, times=1.0 + error)
        is_right = suspicion.state == MRU_SCALE and abs(error) < RIGHT_SCALE
        suspicion = replace(suspicion, words=words, is_acquittal=is_right)
        least, most = LIKELY_ERRORS[suspicion.state]
        is_likely = least < error < most and abs(error) >= suspicion.least_error
        likelihood = likelihood if is_likely else -math.inf
    motions = {name: _least_motion(values) for name, values in foreseen.items()}
    return _Trial(likelihood, misfits, motions, Verdict(suspicion, design, estimator, record[-1].number))


def _least_motion(values: Sequence[float]) -> float:
    """Return the standard deviation of the quarter of `values` that moves least, without a mean that drifts."""
    quarters = np.array_split(np.array(values), 4)
    return min(float(np.std(detrend(quarter))) if len(quarter) else 0.0 for quarter in quarters)


def _know_scale(estimator: KalmanEstimator, state: int, scale: float) -> None:
    """Let an `estimator` begin with a `scale` of the MRU, which is a `state` of it, as known."""
    estimate, covariance = estimator.estimate.copy(), estimator.covariance.copy()
    estimate[state] = scale
    begin_anew(covariance, state, 0.0)
    estimator.reset(estimate, covariance)


def _with_doubt(sensor: str, record: Sequence[RecordedTick]) -> Sequence[RecordedTick]:
    """Return a `record` in which all that a sensor read may be noise; empty: none is doubted."""
    if not sensor:
        return record
    sizes = _sizes(sensor, record)

    def doubted(reading: Measurement) -> Measurement:
        return reading._replace(sigma=sizes[reading.name]) if reading.name in sizes else reading

    return [tick._replace(readings=[doubted(reading) for reading in tick.readings]) for tick in record]


def _rows_of(sensor: str) -> list[str]:
    """Return the measurements of a `sensor`, by name."""
    return [row.name for row in KnownSensors().by_name()[sensor].rows()]


def _without(sensor: str, record: Sequence[RecordedTick]) -> Sequence[RecordedTick]:
    """Return a `record` without what a `sensor` read."""
    rows = _rows_of(sensor)
    return [
        tick._replace(readings=[reading for reading in tick.readings if reading.name not in rows]) for tick in record
    ]


def _sizes(sensor: str, record: Sequence[RecordedTick]) -> dict[str, float]:
    """Return the standard deviations of what a sensor read, by measurement."""
    values: dict[str, list[float]] = {name: [] for name in _rows_of(sensor)}
    for tick in record:
        for reading in tick.readings:
            if reading.name in values:
                values[reading.name].append(reading.value)
    return {name: float(np.std(read)) for name, read in values.items() if read}
