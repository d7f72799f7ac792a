"""Which sea the readings tell: the last two minutes of the MRU under each sea that may be there, and when to look."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from heave_node.numerics.linear_model import LinearModel
from scipy.linalg import block_diag
from wave_vessel_node.sea.shaping_filter import shaping_filter
from wave_vessel_node.vessel.second_order import boom_tip_model

from winch_controller_node.adviser.columns import in_columns
from winch_controller_node.adviser.filter_pass import SETTLING, linear, pass_model, run_pass
from winch_controller_node.adviser.record import TICK, Excerpt, SensorHistory
from winch_controller_node.design.design import ControllerDesign, measurement_models
from winch_controller_node.design.seas import (
    PossibleSeas,
    SeaSeen,
    SeaTracker,
    distance,
    neighbours,
    no_lower_while_it_grows,
)
from winch_controller_node.interface.observations import TICK_COLUMNS, Observations
from winch_controller_node.model.models import boom_tip_block, sea_spectrum, second_order_vessel
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import SeaModelParameters, VesselModelParameters

SENSORS = ("mru", "encoder")
"""Sensors by which the sea is judged; readings of the others depend as much on the cable."""

SHORTEST = 2.0 * SETTLING
"""A shorter record [s] does not tell one sea from another."""

LARGEST = 50.0
"""Largest weight of one squared innovation."""

WORTH, FARTHER = 10.0, 60.0
"""Another sea is assumed where the record is so many nats likelier, and so many more for each factor of e by which its
periods differ from the nominal ones: two minutes are some fifteen waves, by chance of another period."""

REFINEMENTS = (1.2, 1.1)
"""Factors, up and down, by which the likeliest sea is then changed."""


CLEAR = 4.0
"""Heave rate of a sea over the noise of the MRU from which on its period is judged."""

SEA_PATIENCE, LONGER, LONGEST_SEA_PATIENCE = 5.0, 1.3, 120.0
"""Time from one comparison of seas to the next [s], and by what it grows, to the last, while no other is found."""


class SeaLooks:
    """The sea that is seen, and when it is compared with others.

    `design` : the active one
    """

    def __init__(self, design: ControllerDesign) -> None:
        self.tracker = SeaTracker(design)
        self._compared, self._patience = -math.inf, SEA_PATIENCE

    def add(self, observations: Observations, noise: float) -> None:
        """Take in the motion of the boom tip in a batch of `observations`; `noise` is that of the heave rate [m/s]."""
        row = observations.rows.index("mru_heave_rate")
        readings = observations.readings[observations.readings[:, 2] == row]
        for nis in readings[np.isfinite(readings[:, -1]), -1].tolist():
            self.tracker.note_innovation(nis, noise)
        tip = [TICK_COLUMNS.index("tip_heave"), TICK_COLUMNS.index("tip_rate")]
        for heave, rate in observations.ticks[:, tip].tolist():
            self.tracker.update(heave, rate)

    def news(self, now: float, noise: float) -> SeaSeen | None:
        """Return what is seen where it is time `now` [s] to compare seas; None: it is not, `noise` [m/s] hides it."""
        seen = self.tracker.newly_seen()
        if seen is None or seen.heave * seen.frequency < CLEAR * noise or now - self._compared < self._patience:
            return None
        self._compared, self._patience = now, min(LONGER * self._patience, LONGEST_SEA_PATIENCE)
        return seen

    def has_changed(self) -> None:
        """Compare again soon: another sea has just been found."""
        self._patience = SEA_PATIENCE


def likeliest_sea(
    parameters: WinchControllerParameters,
    design: ControllerDesign,
    seas: PossibleSeas,
    excerpt: Excerpt,
    history: SensorHistory,
) -> SeaModelParameters | None:
    """Return the sea that predicts a record best; None where the active one does about as well.

    Parameters
    ----------
    parameters, design : the active ones
    seas : that may be there
    excerpt : the record; one too short is not evaluated, and what the moments say is returned
    history : assumed corrections of the sensors over the record
    """
    # scale and lever arm of the MRU are known by the motion of the unit alone
    assumed = linear(parameters)
    assumed = replace(assumed, sensors=replace(assumed.sensors, use=SENSORS))

    def fits(sea: SeaModelParameters) -> float:
        likelihood = _likelihood(replace(assumed, sea=sea), design, excerpt, history)
        return likelihood - FARTHER * distance(sea, seas.assumed)

    is_long = len(excerpt.ticks) * excerpt.dt >= SHORTEST
    found = _best(seas, fits, parameters.vessel) if is_long else seas.stretched
    return None if found is None else no_lower_while_it_grows(found, seas)


def _likelihood(
    parameters: WinchControllerParameters, design: ControllerDesign, excerpt: Excerpt, history: SensorHistory
) -> float:
    """Return the logarithm of the likelihood of a record."""
    model, sampled = pass_model(parameters, design.cable, design, _boom_tip(parameters.sea, parameters.vessel))
    measurements = measurement_models(parameters, sampled, design.cable)
    mine = excerpt.of(tuple(known.name for known in measurements))
    data = in_columns(mine, measurements, history, judged={}).data
    result = run_pass(model, data, np.ones(len(measurements), dtype=np.bool_))
    late = mine.readings[:, TICK] >= excerpt.first + round(SETTLING / excerpt.dt)
    squares = np.minimum(np.square(result.innovations[late, 0]), LARGEST)
    return -0.5 * float(np.sum(squares + np.log(result.variances[late])))


def _boom_tip(sea: SeaModelParameters, vessel: VesselModelParameters) -> LinearModel:
    """Return white noise to boom tip; wind sea and swell by a filter each, of a shape that is fitted once.

    The shape of their sum is another for each ratio of heights and periods: a fit of it takes a third of a second.
    """
    swell = sea.swell
    if sea.spectrum != "ochi_hubble" or swell.significant_wave_height <= 0.0:
        return boom_tip_block(sea, vessel)
    wind_sea = replace(sea, swell=replace(swell, significant_wave_height=0.0))
    alone = replace(
        wind_sea,
        significant_wave_height=swell.significant_wave_height,
        peak_period=swell.peak_period,
        shape=swell.shape,
    )
    parts = [shaping_filter(sea_spectrum(one), form=one.filter_form, states=6) for one in (wind_sea, alone)]
    count = parts[0].order
    waves = LinearModel(
        A=block_diag(*(part.A for part in parts)),
        B=np.zeros((2 * count, 0)),
        C=np.hstack([part.C for part in parts]),
        D=np.zeros((1, 0)),
        G=block_diag(*(part.G for part in parts)),
        state_names=tuple(f"wave_{index}" for index in range(2 * count)),
        input_names=(),
        output_names=parts[0].output_names,
        noise_names=("waves", "swell"),
    )
    return boom_tip_model(waves, second_order_vessel(sea, vessel))


def _best(
    seas: PossibleSeas, fits: Callable[[SeaModelParameters], float], vessel: VesselModelParameters
) -> SeaModelParameters | None:
    """Return that of the `seas` and neighbours that `fits` best; None: the active one does about as well."""

    def best_of(trials: Sequence[tuple[float, SeaModelParameters]]) -> tuple[float, SeaModelParameters]:
        return max(trials, key=lambda trial: trial[0])

    in_force = (fits(seas.in_force), seas.in_force)
    best = best_of([in_force, *((fits(sea), sea) for sea in seas.others)])
    for factor in REFINEMENTS:
        near = neighbours(best[1], factor, seas.seen, vessel)
        best = best_of([best, *((fits(sea), sea) for sea in near)])
    return best[1] if best[0] > in_force[0] + WORTH else None
