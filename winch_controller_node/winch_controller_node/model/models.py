"""The models a heave compensation controller is made of, and the one place that puts them together.

Signs: heave positive up, payout positive lowers the unit: a x'' + b x' + x = x0 - payout, thesis Eq. 6.4 with
u = -payout. Blocks are continuous and connected by name. `augmented_model` samples them exactly and adds the chain of
delayed commands.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from cable_sim_node.parameters import CableParameters, CableSimParameters
from cable_sim_node.unit_parameters import UnitParameters
from cable_sim_node.vertical.axial_line import AxialLine, axial_line
from cable_sim_node.vertical.linear import (
    TwoStateModel,
    drag_at_unit,
    first_mode,
    fit_two_state,
    heave_transfer_function,
)
from heave_node.numerics.arrays import Array
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY
from heave_node.numerics.linear_model import LinearModel, ModelError, interconnect, linear_model
from heave_node.numerics.linear_sampling import delay_command, discretise, sampled_matrices
from numpy.typing import NDArray
from wave_vessel_node.sea.sea import named_spectrum
from wave_vessel_node.sea.shaping_filter import shaping_filter
from wave_vessel_node.sea.spectra import WaveSpectrum
from wave_vessel_node.vessel.fit import VesselOnCourse
from wave_vessel_node.vessel.rao import RaoError
from wave_vessel_node.vessel.second_order import SecondOrderVessel, boom_tip_model

from winch_controller_node.interface.sensors import MruModelParameters
from winch_controller_node.model.blocks import (
    CableModel,
    cable_block,
    command_name,
    mru_block,
    outlet_block,
    slow_block,
    winch_block,
)
from winch_controller_node.parameters.model import (
    CableModelParameters,
    SeaModelParameters,
    VesselModelParameters,
    WinchModelParameters,
)

SMALLEST_DAMPING_RATIO = 0.002
"""A model is never less damped than this: drag vanishes with the motion, the resonance must stay finite."""


@dataclass(frozen=True)
class PlantBelief:
    """What the controller knows of the plant: enough for a, b and the tension at any length."""

    cable: CableParameters = field(default_factory=CableParameters)  # as in the plant
    unit: UnitParameters = field(default_factory=UnitParameters)  # as in the plant
    water_density: float = SEAWATER_DENSITY  # [kg/m^3]
    gravity: float = STANDARD_GRAVITY  # [m/s^2]
    # above still water [m], for a unit with a box; all of it is under water if not given
    boom_tip_height: float = -math.inf

    def line(self, length: float) -> AxialLine:
        """Return the axial view of the cable at `length` [m]."""
        return axial_line(
            CableSimParameters(
                length=length,
                cable=self.cable,
                unit=self.unit,
                water_density=self.water_density,
                gravity=self.gravity,
            ),
            self.boom_tip_height,
        )


def cable_model(
    plant: PlantBelief, parameters: CableModelParameters, length: float, omegas: Array, weights: Array
) -> CableModel:
    """Return the two-state cable of a `plant` at `length` [m]: as given in `parameters`, or fitted to the exact bar.

    The fit weighs the transfer function boom tip to unit at `omegas` [rad/s] with `weights`, for example the amplitude
    spectrum of the boom tip; drag is linearised about `parameters.drag_amplitude`. A damping that is given holds at any
    speed.
    """
    line = plant.line(length)
    a, b = parameters.inertia, parameters.damping
    if a == 0.0 or b == 0.0:
        fit = fitted_cable(plant, parameters, length, omegas, weights)
        a = a or fit.a
        b = b or max(fit.b, 2.0 * SMALLEST_DAMPING_RATIO * math.sqrt(max(fit.a, 0.0)))
    a, b = a * parameters.inertia_factor, b * parameters.damping_factor
    return CableModel(a, b, **_exact(line, parameters, length, a))


def fitted_cable(
    plant: PlantBelief, parameters: CableModelParameters, length: float, omegas: Array, weights: Array
) -> TwoStateModel:
    """Return the two states that are nearest to the exact bar of a `plant` at `length` [m].

    `omegas` [rad/s], `weights` and `parameters` are as in `cable_model`.
    """
    transfer = heave_transfer_function(plant.line(length), length, omegas, amplitude=parameters.drag_amplitude)
    # weighting the inverse 1 - a w^2 + i b w keeps a resonance in the band from ruling the fit
    return fit_two_state(omegas, transfer.unit_heave, weights=weights / (1.0 + np.abs(transfer.unit_heave) ** 2))


def _exact(line: AxialLine, parameters: CableModelParameters, length: float, a: float) -> dict[str, float]:
    """Return what no fit is needed for; an inertia that is given in place of `a` is that of any motion."""
    stretch = sum(piece.length / piece.axial_stiffness for piece in line.pieces(length))
    drag = 0.0 if parameters.damping > 0.0 else parameters.damping_factor * stretch * drag_at_unit(line, length)
    exact = {
        "stiffness": 1.0 / stretch,
        "static_tension": line.static_top_tension(length),
        "unit_weight": line.unit.weight,
        "drag": drag,
    }
    if parameters.inertia > 0.0:
        return exact
    mode = first_mode(line, length)
    return exact | {
        "natural_ratio": parameters.inertia_factor * mode.a / a,
        "participation": mode.participation,
    }


def sea_spectrum(sea: SeaModelParameters) -> WaveSpectrum:
    """Return the spectrum of the `sea` that the controller is designed for."""
    return named_spectrum(sea)


def _on_course(sea: SeaModelParameters, vessel: VesselModelParameters) -> VesselOnCourse:
    heading = sea.direction - vessel.heading
    return VesselOnCourse(vessel.rao_file, vessel.boom_tip_arm, heading, vessel.speed, vessel.accept_implausible)


@lru_cache(maxsize=64)
def second_order_vessel(sea: SeaModelParameters, vessel: VesselModelParameters) -> SecondOrderVessel | None:
    """Return the `vessel` that the model is made of; None where the boom tip follows the surface of the `sea`.

    That of a vessel with RAOs is fitted to them in the sea. Raises ModelError where the RAOs cannot be read.
    """
    if vessel.model == "direct":
        return None
    if vessel.model == "second_order":
        return SecondOrderVessel(vessel.natural_frequency, vessel.damping_ratio, vessel.gain)
    try:
        return _on_course(sea, vessel).fit(sea_spectrum(sea)).vessel
    except RaoError as error:
        raise ModelError(f"vessel.rao_file: {error}") from error


def boom_tip_response(sea: SeaModelParameters, vessel: VesselModelParameters, omega: Array) -> NDArray[np.complex128]:
    """Return boom-tip heave per wave amplitude at `omega` [rad/s], shape (n,): of a vessel with RAOs by themselves.

    `sea` and `vessel` are those of the design. Raises ModelError where the RAOs cannot be read.
    """
    if vessel.model == "rao":
        try:
            return _on_course(sea, vessel).response(omega)
        except RaoError as error:
            raise ModelError(f"vessel.rao_file: {error}") from error
    second_order = second_order_vessel(sea, vessel)
    return np.ones(omega.shape, dtype=complex) if second_order is None else second_order.response(omega)


@lru_cache(maxsize=64)
def boom_tip_block(sea: SeaModelParameters, vessel: VesselModelParameters) -> LinearModel:
    """Return white noise to boom tip: shaping filter of a `sea` and `vessel` (thesis Eq. 6.23, 6.26).

    Outputs wave_elevation, boom_tip_heave, boom_tip_heave_rate. The noise carries the intensity pi of one-sided
    spectra.
    """
    waves = shaping_filter(sea_spectrum(sea), form=sea.filter_form, states=sea.filter_states)
    return boom_tip_model(waves, second_order_vessel(sea, vessel))


@dataclass(frozen=True)
class ModelInputs:
    """All that the augmented model is made of."""

    cable: CableModel  # two-state cable
    winch: WinchModelParameters  # as assumed
    sea: SeaModelParameters  # as assumed
    vessel: VesselModelParameters  # as assumed
    cable_disturbance: float = 0.0  # white acceleration of the unit [m/s^2/sqrt(Hz)]
    mru: MruModelParameters | None = None  # the motion reference unit; None: no MRU states
    slow: tuple[tuple[str, float], ...] = ()  # slow states by name, with their drift [unit/sqrt(s)]
    # white noise to boom tip as `boom_tip_block` gives it; None: that of sea and vessel
    boom_tip: LinearModel | None = None


def continuous_model(inputs: ModelInputs) -> LinearModel:
    """Return `inputs` connected to a continuous model, without the command delay (thesis Eq. 6.28 and more)."""
    blocks = [
        cable_block(inputs.cable, inputs.cable_disturbance),
        winch_block(inputs.winch),
        boom_tip_block(inputs.sea, inputs.vessel) if inputs.boom_tip is None else inputs.boom_tip,
        outlet_block(),
    ]
    if inputs.mru is not None:
        blocks.append(mru_block(inputs.mru))
    blocks += [slow_block(name, drift) for name, drift in inputs.slow]
    return interconnect(blocks)


@lru_cache(maxsize=64)
def augmented_model(inputs: ModelInputs, tick_period: float) -> LinearModel:
    """Return `inputs` as a model sampled at ticks of `tick_period` [s], with the exact command delay.

    One input, the command of the tick. States: unit, payout, boom tip (vessel, waves), MRU high-pass, slow states, and
    past commands `<command>_1` (the newest) on.
    """
    model = continuous_model(inputs)
    return delay_command(model, tick_period, inputs.winch.command_delay, [command_name(inputs.winch)])


def sea_noise_covariance(inputs: ModelInputs, tick_period: float, order: int) -> Array:
    """Return the waves' share of the process noise of a tick of `augmented_model(inputs, tick_period)`.

    The model has `order` states; shape (order, order).
    """
    model = continuous_model(inputs)
    waves = [i for i, name in enumerate(model.noise_names) if name == "waves"]
    only_waves = replace(model, G=model.G[:, waves], noise_names=("waves",))
    covariance = sampled_matrices(only_waves, tick_period)[2]
    return np.pad(covariance, (0, order - model.order))


@lru_cache(maxsize=8)
def shadow_model(cable: CableModel, tick_period: float) -> LinearModel:
    """Return the uncompensated unit on a `cable`, sampled at `tick_period` [s].

    boom_tip_heave and its rate in, the unit's heave and rate out; the states are those of the first mode, in which the
    unit swings (see `first_mode`). The boom tip moves straight within a tick. It makes the guard's and the display's
    "what the unit would do".
    """
    ramp = linear_model(
        [[0.0, 1.0], [0.0, 0.0]],
        states=("tip", "tip_rate"),
        inputs={"boom_tip_heave": [0.0, 0.0], "boom_tip_heave_rate": [0.0, 0.0]},
        outputs={"tip": [1.0, 0.0]},
    )
    mode = cable_block(replace(cable, a=cable.natural_a))
    joined = interconnect([replace(mode, input_names=("tip", "payout")), ramp])
    sampled = discretise(joined, tick_period)
    share = cable.participation
    heave, rate = "unit_uncompensated_heave", "unit_uncompensated_heave_rate"
    return linear_model(
        sampled.A[:2, :2],
        states=("mode_heave", "mode_heave_rate"),
        inputs={"boom_tip_heave": sampled.A[:2, 2], "boom_tip_heave_rate": sampled.A[:2, 3]},
        outputs={heave: [share, 0.0], rate: [0.0, share]},
        feedthrough={(heave, "boom_tip_heave"): 1.0 - share, (rate, "boom_tip_heave_rate"): 1.0 - share},
        dt=tick_period,
    )


@dataclass(frozen=True, eq=False)
class LoopRows:
    """Rows and indices of a model."""

    payout: Array  # row of payout [m], shape (n,)
    payout_rate: Array  # row of the payout rate [m/s], shape (n,)
    # what the active command adds to that rate, in its unit: not 0 for a first-order winch without delay
    payout_rate_through: float
    tip: Array  # heave of the boom tip [m] and its rate, shape (2, n)
    unit_states: NDArray[np.int64]  # indices of unit heave and rate in the state


def loop_rows(model: LinearModel) -> LoopRows:
    """Return the rows of a design's model."""
    return LoopRows(
        payout=model.row("payout"),
        payout_rate=model.row("payout_rate"),
        payout_rate_through=float(model.D[model.output_names.index("payout_rate"), 0]),
        tip=np.array([model.row("boom_tip_heave"), model.row("boom_tip_heave_rate")]),
        unit_states=np.array([model.state("unit_heave"), model.state("unit_heave_rate")]),
    )
