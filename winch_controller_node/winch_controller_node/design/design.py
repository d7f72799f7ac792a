"""From the parameters to a controller: the augmented model, what is measured, gains and scales, in one frozen object.

>>> design = design_controller(WinchControllerParameters(), tick_period=0.05)
>>> estimator = design.make_estimator()
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from cable_sim_node.physics.hydrodynamics import wet_part
from heave_core.filter import Drag, Slack, check_sizes
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel, covariance_factor, state_covariance

from winch_controller_node.interface.sensors import (
    LEVER_ARM_X,
    LEVER_ARM_Y,
    MRU_SCALE,
    MeasurementRow,
    SlowState,
    sensors_that_see,
)
from winch_controller_node.laws.law import ControlLaw, LawDesign
from winch_controller_node.laws.parts.winch_limits import WinchLimits, winch_limits
from winch_controller_node.laws.registry import law_class, parameters_of_place
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.estimator import KalmanEstimator, MeasurementModel
from winch_controller_node.model.lqr import DesignError, QuadraticCost, check_detectable
from winch_controller_node.model.models import (
    ModelInputs,
    PlantBelief,
    augmented_model,
    boom_tip_block,
    cable_model,
    fitted_cable,
    sea_noise_covariance,
)
from winch_controller_node.model.regulator import full_gain, is_sea_state, is_sensor_state, weighted_cost
from winch_controller_node.model.simulated_unit import cable_slack, unit_drag
from winch_controller_node.node_parameters import WinchControllerParameters

FIT_FREQUENCIES = 80
"""Frequencies of the fit of the two-state cable, from 0.3 to 2.5 times the boom tip's mean frequency."""

LONGEST_DELAY = 5.0
"""Command delay [s] above which a design is refused: no boom-tip prediction reaches that far (17 % error at 2 s)."""


@dataclass(frozen=True, eq=False)
class ControllerDesign:
    """Everything a control law needs for one deployed length. All in SI, states by `model.state_names`."""

    parameters: WinchControllerParameters  # of the controller
    tick_period: float  # [s]
    length: float  # deployed, that it was designed for [m]
    cable: CableModel  # its two-state cable
    model: LinearModel  # sampled augmented model; one input, the command
    # what the estimator may be given, by name: mru_heave, mru_heave_rate, unit_heave (from depth, positive up, about
    # the expected mean), payout (encoder), unit_velocity, unit_acceleration, tension (about the static one)
    measurements: tuple[MeasurementModel, ...]
    initial_covariance: Array  # of the estimate at the start, shape (n, n)
    gain: Array  # u = -gain x, shape (n,): optimum for all states (thesis 6.3), zero for sensor states
    cost: QuadraticCost  # of the model's states
    sigma: dict[str, float]  # stationary standard deviation of each output with the winch locked
    sea_noise: Array  # what the waves contribute to the process noise of a tick, shape (n, n)
    # of the law that the parameters name, made beforehand, shape (n,) each; empty: the law makes them itself
    own_gains: Mapping[str, Array] = field(default_factory=dict)

    @property
    def command(self) -> str:
        """Name of the model's input."""
        return self.model.input_names[0]

    @property
    def delay_states(self) -> tuple[str, ...]:
        """Names of the past commands, the newest first."""
        return tuple(name for name in self.model.state_names if name.startswith(self.command + "_"))

    @property
    def sea_states(self) -> tuple[str, ...]:
        """Names of the states of waves and vessel: those that grow with the sea."""
        return tuple(name for name in self.model.state_names if is_sea_state(name))

    @property
    def unit_weight(self) -> float:
        """Submerged weight of the unit as modelled [N]."""
        unit = self.parameters.unit
        return (unit.mass - self.parameters.water_density * unit.volume) * self.parameters.gravity

    def static_tension_at(self, length: float) -> float:
        """Return the tension at the top at rest with a `length` [m] out [N]; as `cable` where that knows no weights."""
        p, known = self.parameters, self.cable.static_tension
        if known <= 0.0:
            return known
        paid_out = p.cable.weight_in_fluid(p.water_density, p.gravity) * (length - self.length)
        return known + paid_out - self._buoyancy_at(length) + self._buoyancy_at(self.length)

    @property
    def wet_tension(self) -> float:
        """Tension at the top at rest with all of the unit under water, as at the seabed [N]."""
        return self.cable.static_tension - self._buoyancy_at(math.inf) + self._buoyancy_at(self.length)

    def _buoyancy_at(self, length: float) -> float:
        p = self.parameters
        wet, _ = wet_part.py_func(length - p.boom_tip_height, p.unit.box.height, 0.0, 0.0)
        return float(wet * p.water_density * p.unit.volume * p.gravity)

    def wave_round_trip(self, payout: float) -> float:
        """Return the time of an axial wave down the cable and back with a `payout` [m] out [s]."""
        length = self.parameters.length + payout
        pieces = assumed_plant(self.parameters).line(length).pieces(length)
        return 2.0 * sum(piece.length * math.sqrt(piece.mass / piece.axial_stiffness) for piece in pieces)

    def make_estimator(self) -> KalmanEstimator:
        """Return a Kalman filter at its initial state."""
        estimator = self.parameters.estimator
        return KalmanEstimator(
            self.model,
            self.measurements,
            self.initial_covariance,
            gate=estimator.gate,
            gate_limit=estimator.gate_limit,
            largest_age=_kept(self.parameters, self.tick_period) - 1,
            drag=self.drag,
            slack=self.slack,
        )

    @property
    def drag(self) -> Drag:
        """Drag of the unit in the model."""
        return unit_drag(self.model, self.cable)

    @property
    def slack(self) -> Slack:
        """When the cable is slack in the model."""
        return cable_slack(self.model, self.cable, self.measurements)

    @property
    def limits(self) -> WinchLimits:
        """Active limits of the winch."""
        return winch_limits(self.parameters.winch, self.parameters.limits, self.cable.static_tension)

    def make_law(self) -> ControlLaw:
        """Return the law that the parameters name, at its initial state.

        Raises DesignError where winch or sensors do not serve that law.
        """
        p = self.parameters
        missing = [sensor for sensor in law_class(p.law).required_sensors if sensor not in p.sensors.use]
        if missing:
            raise DesignError(
                f"law {p.law} needs the sensor {missing[0]}: add it to sensors.use, or choose another law"
            )
        return law_class(p.law)(self._for_law, self._of_law)

    def with_own_gains(self) -> ControllerDesign:
        """Return it with the law's own gains: of such a design a law is made within a tick.

        Raises DesignError where there are none.
        """
        return replace(self, own_gains=law_class(self.parameters.law).own_gains(self._for_law, self._of_law))

    @property
    def _for_law(self) -> LawDesign:
        p = self.parameters
        return LawDesign(self.model, p.winch, self.limits, p.weights, self.gain, self.own_gains)

    @property
    def _of_law(self) -> object:
        """The law's own parameters, the group of its name or those given with its place; None: it has none."""
        p = self.parameters
        return parameters_of_place(law_class(p.law), p.law_parameters) if ":" in p.law else getattr(p, p.law, None)


def _kept(parameters: WinchControllerParameters, tick_period: float) -> int:
    """Return the ticks that the estimator keeps, the present one among them."""
    return round(parameters.estimator.largest_age / tick_period) + 1


def design_controller(
    parameters: WinchControllerParameters,
    *,
    tick_period: float,
    length: float | None = None,
    cable: CableModel | None = None,
) -> ControllerDesign:
    """Design estimator and gains for `length` [m] (default: parameters.length), sampled at `tick_period` [s].

    `cable` is the two-state cable there, where it is known already (most of the work is its fit).

    Raises
    ------
    DesignError : for a wrong sensor set, a unit that floats, a delay too long for any prediction, a model that does not
        fit the core, singular weights, a model that is not stabilisable or not detectable; the message says which.
    """
    length = parameters.length if length is None else length
    check_inputs(parameters, tick_period)
    cable = assumed_cable(parameters, length) if cable is None else cable
    model = augmented_model(model_inputs(parameters, cable), tick_period)
    measurements = measurement_models(parameters, model, cable)
    try:
        check_sizes(model.order, len(measurements), _kept(parameters, tick_period))
    except ValueError as error:
        raise DesignError(str(error)) from error
    _check_observability(parameters, model, measurements)
    cost = weighted_cost(parameters.weights, model)
    gain = full_gain(model, cost)
    covariance, sigma = _locked_covariance(parameters, model, cable)
    return ControllerDesign(
        parameters=parameters,
        tick_period=tick_period,
        length=length,
        cable=cable,
        model=model,
        measurements=measurements,
        initial_covariance=covariance,
        gain=gain,
        cost=cost,
        sigma=sigma,
        sea_noise=sea_noise_covariance(model_inputs(parameters, cable), tick_period, model.order),
    )


FOLLOWED = 0.05
"""Change of the length of cable, relative, from which on another design is made."""


def length_followed(parameters: WinchControllerParameters, payout: float, last: float) -> float:
    """Return the length to design for [m].

    Parameters
    ----------
    parameters : whose length is that at payout 0
    payout : the mean one [m]
    last : that of the design before, which stays as long as it is near enough [m]
    """
    length = max(parameters.length + payout, 1.0)
    return last if abs(length / last - 1.0) < FOLLOWED else length


def with_boom_tip(design: ControllerDesign, boom_tip: LinearModel) -> ControllerDesign:
    """Return the design's model and measurements for another motion of the boom tip; gain and cost stay, unfit for it.

    `boom_tip` has white noise for its input and the outputs of `models.boom_tip_block`.
    """
    parameters, cable = design.parameters, design.cable
    inputs = replace(model_inputs(parameters, cable), boom_tip=boom_tip)
    model = augmented_model(inputs, design.tick_period)
    covariance, sigma = _locked_covariance(parameters, model, cable)
    return replace(
        design,
        model=model,
        measurements=measurement_models(parameters, model, cable),
        initial_covariance=covariance,
        sigma=sigma,
        sea_noise=sea_noise_covariance(inputs, design.tick_period, model.order),
        own_gains={},
    )


def carry_by_name(old: ControllerDesign, new: ControllerDesign) -> Array:
    """Return the matrix that takes a state of `old` to one of `new`, shape (n_new, n_old).

    States of one name are the same; a longer chain of past commands repeats its oldest, any other new state is zero.
    """
    chain = old.delay_states
    matrix = np.zeros((new.model.order, old.model.order))
    for row, name in enumerate(new.model.state_names):
        if old.model.has_state(name):
            matrix[row, old.model.state(name)] = 1.0
        elif chain and name in new.delay_states:
            matrix[row, old.model.state(chain[-1])] = 1.0
    return matrix


def check_inputs(parameters: WinchControllerParameters, tick_period: float) -> None:
    """Refuse `parameters` and a `tick_period` [s] that no design serves; raises DesignError."""
    if not tick_period > 0.0:
        raise DesignError(f"tick_period must be above 0; got {tick_period:g} s")
    delay = parameters.winch.command_delay
    if delay > LONGEST_DELAY:
        raise DesignError(
            f"winch.command_delay = {delay:g} s is longer than the boom tip can usefully be predicted "
            f"({LONGEST_DELAY:g} s)"
        )
    use = parameters.sensors.use
    if "encoder" not in use:
        raise DesignError("sensors.use must include the encoder: nothing else measures the payout")
    of_motion = sensors_that_see("boom_tip", "unit")
    if not set(of_motion) & set(use):
        raise DesignError(f"sensors.use must include one of {', '.join(of_motion)}: nothing else measures the motion")
    unit = parameters.unit
    if not unit.weight_in_fluid(parameters.water_density, parameters.gravity) > 0.0:
        raise DesignError(
            f"the load floats: unit.volume of {unit.volume:g} m^3 displaces "
            f"{unit.volume * parameters.water_density:g} kg of water, unit.mass is {unit.mass:g} kg; check both"
        )


def assumed_plant(parameters: WinchControllerParameters) -> PlantBelief:
    """Return what the `parameters` say of cable, unit and water."""
    p = parameters
    return PlantBelief(p.cable, p.unit, p.water_density, p.gravity, p.boom_tip_height)


def assumed_cable(parameters: WinchControllerParameters, length: float) -> CableModel:
    """Return the two-state cable at `length` [m] of the plant of `parameters`, fitted where the boom tip has energy."""
    return cable_model(assumed_plant(parameters), parameters.cable_model, length, *_band(parameters))


def error_of_two_states(parameters: WinchControllerParameters, length: float) -> float:
    """Return the relative error of the unit's motion by two fitted states against that by the cable's waves.

    `parameters` : of plant and sea; `length` : of cable [m]
    """
    return fitted_cable(assumed_plant(parameters), parameters.cable_model, length, *_band(parameters)).error


def _band(parameters: WinchControllerParameters) -> tuple[Array, Array]:
    """Return frequencies [rad/s] about the mean one of the boom tip, and the amplitude that it has there."""
    tip = boom_tip_block(parameters.sea, parameters.vessel)
    P = state_covariance(tip)
    heave, rate = tip.row("boom_tip_heave"), tip.row("boom_tip_heave_rate")
    mean_frequency = math.sqrt(float(rate @ P @ rate) / float(heave @ P @ heave))
    omegas = np.linspace(0.3, 2.5, FIT_FREQUENCIES) * mean_frequency
    response = [
        np.linalg.norm(heave @ np.linalg.solve(1j * w * np.eye(tip.order) - tip.A, tip.G.astype(complex)))
        for w in omegas
    ]
    return omegas, np.array(response)


def model_inputs(parameters: WinchControllerParameters, cable: CableModel) -> ModelInputs:
    """Return what the augmented model is made of: these parameters, and the two-state `cable` at a length."""
    sensors = parameters.sensors
    return ModelInputs(
        cable=cable,
        winch=parameters.winch,
        sea=parameters.sea,
        vessel=parameters.vessel,
        cable_disturbance=parameters.cable_model.disturbance,
        mru=sensors.mru if "mru" in sensors.use else None,
        slow=tuple((state.name, state.drift) for state in slow_states(parameters, cable)),
    )


def slow_states(parameters: WinchControllerParameters, cable: CableModel) -> list[SlowState]:
    """Return the errors of the sensors of `parameters` that the estimator follows, in the units of the model.

    `cable` : whose static tension is the unit of a load cell
    """
    return [
        SlowState(state.name, unit * state.drift, unit * state.sigma)
        for sensor in parameters.sensors.in_use().values()
        for unit in [sensor.unit(cable.static_tension)]
        for state in sensor.slow_states()
    ]


def measurement_models(
    parameters: WinchControllerParameters, model: LinearModel, cable: CableModel
) -> tuple[MeasurementModel, ...]:
    """Return the measurements of the sensors that `parameters` use, rows of `model`.

    The tension's noise goes with the `cable`.
    """
    return tuple(
        MeasurementModel(
            row.name,
            name,
            _weights(model, row),
            row.sigma * sensor.unit(cable.static_tension),
            scale_state=model.state(row.scale_state) if model.has_state(row.scale_state) else None,
            is_gated=row.is_gated,
        )
        for name, sensor in parameters.sensors.in_use().items()
        for row in sensor.rows()
    )


def _weights(model: LinearModel, row: MeasurementRow) -> Array:
    """Return the weights of the states in a measurement, shape (n,)."""
    weights = model.row(row.output).copy()
    if model.has_state(row.state):
        weights[model.state(row.state)] = 1.0
    return np.asarray(weights)


def _check_observability(
    parameters: WinchControllerParameters, model: LinearModel, measurements: tuple[MeasurementModel, ...]
) -> None:
    """Refuse a sensor set that does not determine the state.

    Scale and lever arm show only in motion, so that a constant linear test cannot judge them: they need a sensor on the
    unit or the cable that shows how much the boom tip really moves.
    """
    use = parameters.sensors.use
    in_motion = (MRU_SCALE, LEVER_ARM_X, LEVER_ARM_Y)
    asked = [name for name in in_motion if model.has_state(name)]
    *others, last = below = sensors_that_see("unit", "cable")
    if asked and not set(below) & set(use):
        raise DesignError(
            f"{' and '.join(asked)} cannot be observed with the sensors {', '.join(use)}: add {', '.join(others)} or "
            f"{last}, or set its sigma to 0"
        )
    kept = [name for name in model.state_names if name not in in_motion]
    index = [model.state(name) for name in kept]
    check_detectable(model.select_states(kept), np.array([m.row[index] for m in measurements]), use)


def _locked_covariance(
    parameters: WinchControllerParameters, model: LinearModel, cable: CableModel
) -> tuple[Array, dict[str, float]]:
    """Return the covariance at the start and the outputs' standard deviations, winch locked, from the stable part."""
    moving = [name for name in model.state_names if not is_sensor_state(name) and not name.startswith("payout")]
    free = _without_payout(model, moving)
    P = state_covariance(free)
    covariance = np.zeros((model.order, model.order))
    index = [model.state(name) for name in moving]
    covariance[np.ix_(index, index)] = P
    start = {"payout": 1.0, "payout_rate": 0.1}
    start |= {state.name: state.sigma for state in slow_states(parameters, cable)}
    start |= dict.fromkeys(("mru_offset", "mru_offset_rate"), 0.1)
    for name, sigma in start.items():
        if model.has_state(name):
            covariance[model.state(name), model.state(name)] = sigma**2
    variances = np.einsum("ij,jk,ik->i", model.C[:, index], P, model.C[:, index])
    return covariance, dict(zip(model.output_names, np.sqrt(np.maximum(variances, 0.0)).tolist(), strict=True))


def _without_payout(model: LinearModel, names: list[str]) -> LinearModel:
    """Return the model of the states `names` with payout and past commands held at zero."""
    index = [model.state(name) for name in names]
    return LinearModel(
        A=model.A[np.ix_(index, index)],
        B=np.zeros((len(index), 0)),
        C=np.zeros((0, len(index))),
        D=np.zeros((0, 0)),
        G=covariance_factor(model.noise_covariance[np.ix_(index, index)]),
        state_names=tuple(names),
        input_names=(),
        output_names=(),
        noise_names=tuple(f"noise_{i}" for i in range(len(index))),
        dt=model.dt,
    )


FORESEEN = 12.0
"""Time over which the boom tip shall move as it was predicted [s]: most of a swell's period."""

EVERY = 2
"""Ticks from one compared moment to the next."""

EXACTNESS, LOOSENING = 1e-3, 2.6
"""Largest difference of the two at first, over the standard deviation of the boom tip's heave, and the time [s] in
which it may grow by a factor of e: another sea must predict something else in the end."""


def carry_sea(old: ControllerDesign, new: ControllerDesign) -> tuple[Array, Array]:
    """Return the matrix that takes a state of `old` to one of `new`, and the covariance that this adds.

    Shapes (n_new, n_old) and (n_new, n_new). The states of a shaping filter mean something else in each sea, and so do
    those of a vessel that is fitted to RAOs. What goes on without a step is the boom tip's motion, now and in the next
    seconds: all that the command depends on. All other states are carried by name.
    """
    waves = [i for i, name in enumerate(new.model.state_names) if name.startswith("wave_")]
    seen_old, seen_new = _foreseen(old.model), _foreseen(new.model)
    matrix = carry_by_name(old, new)
    matrix[waves] = 0.0
    if new.model.has_state("vessel_heave"):
        # in metres of a vessel's heave, of which the boom tip takes a share
        vessel = [new.model.state(name) for name in ("vessel_heave", "vessel_heave_rate")]
        matrix[vessel] *= (seen_old[0] @ matrix[vessel[0]]) / seen_new[0, vessel[0]]
    time = EVERY * new.tick_period * np.arange(len(seen_new))
    sigma = (EXACTNESS * new.sigma["boom_tip_heave"] * np.exp(time / LOOSENING))[:, None]
    prior = new.initial_covariance[np.ix_(waves, waves)]
    # scaled: wave states are derivatives of one signal, of very different sizes
    size = np.sqrt(np.diag(prior))
    scaled = seen_new[:, waves] * size / sigma
    covariance = np.linalg.inv(scaled.T @ scaled + np.linalg.inv(prior / np.outer(size, size)))
    wanted = seen_old - seen_new @ matrix
    matrix[waves] = size[:, None] * (covariance @ scaled.T @ (wanted / sigma))
    added = np.zeros((new.model.order, new.model.order))
    added[np.ix_(waves, waves)] = covariance * np.outer(size, size)
    return matrix, added


def _foreseen(model: LinearModel) -> Array:
    """Return the rows of the boom tip's heave over the next seconds, shape (moments, n)."""
    assert model.dt is not None
    row = model.row("boom_tip_heave")
    rows, ahead = [], np.linalg.matrix_power(model.A, EVERY)
    for _ in range(round(FORESEEN / model.dt / EVERY)):
        rows.append(row)
        row = row @ ahead
    return np.array(rows)
