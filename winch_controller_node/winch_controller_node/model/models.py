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
from cable_sim_node.parameters import CableParameters, CableSimParameters, UnitParameters
from cable_sim_node.vertical.axial_line import AxialLine, axial_line
from cable_sim_node.vertical.linear import fit_two_state, heave_transfer_function
from heave_node.arrays import Array
from heave_node.constants import SEAWATER_DENSITY, STANDARD_GRAVITY
from heave_node.linear_model import LinearModel, ModelError, interconnect, linear_model
from heave_node.linear_sampling import delay_command, discretise, sampled_matrices
from wave_vessel_node.sea.sea import named_spectrum
from wave_vessel_node.sea.shaping_filter import shaping_filter
from wave_vessel_node.sea.spectra import WaveSpectrum
from wave_vessel_node.vessel.second_order import SecondOrderVessel, boom_tip_model

from winch_controller_node.interface.sensors import MruModelParameters
from winch_controller_node.parameters.model import (
    CableModelParameters,
    SeaModelParameters,
    VesselModelParameters,
    WinchModelParameters,
)

RATE_COMMAND = "payout_rate_command"
PAYOUT_COMMAND = "payout_command"

SMALLEST_DAMPING_RATIO = 0.002
"""A model is never less damped than this: drag vanishes with the motion, the resonance must stay finite."""


@dataclass(frozen=True)
class CableModel:
    """a x'' + b x' + x = x0 - payout (thesis Eq. 6.2).

    Attributes
    ----------
    a : [s^2]; b : [s]
    stiffness : top tension per metre of boom tip over outlet and unit [N/m]
    static_tension : mean tension at the top [N]
    """

    a: float
    b: float
    stiffness: float = 1.0
    static_tension: float = 0.0

    def __post_init__(self) -> None:
        if not (self.a > 0.0 and self.b >= 0.0):
            raise ModelError(f"a cable model needs a > 0 and b >= 0; got a = {self.a:g} s^2, b = {self.b:g} s")


@dataclass(frozen=True)
class PlantBelief:
    """What the controller knows of cable and unit: enough for a, b and the tension at any length."""

    cable: CableParameters = field(default_factory=CableParameters)
    unit: UnitParameters = field(default_factory=UnitParameters)
    water_density: float = SEAWATER_DENSITY
    gravity: float = STANDARD_GRAVITY

    def line(self, length: float) -> AxialLine:
        """Return the axial view of the cable at `length` [m]."""
        return axial_line(
            CableSimParameters(
                length=length,
                cable=self.cable,
                unit=self.unit,
                water_density=self.water_density,
                gravity=self.gravity,
            )
        )


def cable_model(
    plant: PlantBelief, parameters: CableModelParameters, length: float, omegas: Array, weights: Array
) -> CableModel:
    """Return the two-state cable at `length` [m]: as given in `parameters`, or fitted to the exact bar.

    The fit weighs the transfer function boom tip to unit at `omegas` [rad/s] with `weights`, for example the amplitude
    spectrum of the boom tip; drag is linearised about `parameters.drag_amplitude`.
    """
    line = plant.line(length)
    a, b = parameters.inertia, parameters.damping
    if a == 0.0 or b == 0.0:
        transfer = heave_transfer_function(line, length, omegas, amplitude=parameters.drag_amplitude)
        # weighting the inverse 1 - a w^2 + i b w keeps a resonance in the band from ruling the fit
        fit = fit_two_state(omegas, transfer.unit_heave, weights=weights / (1.0 + np.abs(transfer.unit_heave) ** 2))
        a = a or fit.a
        b = b or max(fit.b, 2.0 * SMALLEST_DAMPING_RATIO * math.sqrt(max(fit.a, 0.0)))
    stretch = sum(piece.length / piece.axial_stiffness for piece in line.pieces(length))
    return CableModel(
        a * parameters.inertia_factor, b * parameters.damping_factor, 1.0 / stretch, line.static_top_tension(length)
    )


def cable_block(cable: CableModel, disturbance: float = 0.0) -> LinearModel:
    """Return the cable and unit: inputs boom_tip_heave and payout, thesis Eq. 6.6, outputs of the unit and the tension.

    `disturbance` is the density of a white acceleration of the unit [m/s^2/sqrt(Hz)], two-sided.
    """
    a, b, k = cable.a, cable.b, cable.stiffness
    return linear_model(
        [[0.0, 1.0], [-1.0 / a, -b / a]],
        states=("unit_heave", "unit_heave_rate"),
        inputs={"boom_tip_heave": [0.0, 1.0 / a], "payout": [0.0, -1.0 / a]},
        outputs={
            "unit_heave": [1.0, 0.0],
            "unit_heave_rate": [0.0, 1.0],
            "unit_heave_acceleration": [-1.0 / a, -b / a],
            "tension": [-k, 0.0],
        },
        feedthrough={
            ("unit_heave_acceleration", "boom_tip_heave"): 1.0 / a,
            ("unit_heave_acceleration", "payout"): -1.0 / a,
            ("tension", "boom_tip_heave"): k,
            ("tension", "payout"): -k,
        },
        noises={"unit_disturbance": [0.0, disturbance]},
    )


def winch_block(winch: WinchModelParameters) -> LinearModel:
    """Return the winch: first order (thesis Eq. 6.1, input payout_command) or speed servo (input payout_rate_command).

    The servo's payout set-point is the mean payout, about which `payout` counts: v' = (v_set - k_p payout - v)/T.
    """
    if winch.law == "first_order":
        K = winch.position_rate
        return linear_model(
            [[-K]],
            states=("payout",),
            inputs={PAYOUT_COMMAND: [K]},
            outputs={"payout": [1.0], "payout_rate": [-K]},
            feedthrough={("payout_rate", PAYOUT_COMMAND): K},
            noises={"winch_disturbance": [winch.disturbance]},
        )
    T = winch.time_constant
    return linear_model(
        [[0.0, 1.0], [-winch.position_gain / T, -1.0 / T]],
        states=("payout", "payout_rate"),
        inputs={RATE_COMMAND: [0.0, 1.0 / T]},
        outputs={
            "payout": [1.0, 0.0],
            "payout_rate": [0.0, 1.0],
            "payout_acceleration": [-winch.position_gain / T, -1.0 / T],
        },
        feedthrough={("payout_acceleration", RATE_COMMAND): 1.0 / T},
        noises={"winch_disturbance": [0.0, winch.disturbance]},
    )


def outlet_block() -> LinearModel:
    """Return the outlet: boom-tip heave less payout, what is left of the heave where the cable leaves the vessel."""
    return linear_model(
        np.zeros((0, 0)),
        states=(),
        inputs={"boom_tip_heave": [], "payout": []},
        outputs={"outlet_heave": []},
        feedthrough={("outlet_heave", "boom_tip_heave"): 1.0, ("outlet_heave", "payout"): -1.0},
    )


def sea_spectrum(sea: SeaModelParameters) -> WaveSpectrum:
    """Return the spectrum the controller is designed for."""
    return named_spectrum(sea)


@lru_cache(maxsize=64)
def boom_tip_block(sea: SeaModelParameters, vessel: VesselModelParameters) -> LinearModel:
    """Return white noise to boom tip: shaping filter and vessel (thesis Eq. 6.23, 6.26).

    Outputs wave_elevation, boom_tip_heave, boom_tip_heave_rate. The noise carries the intensity pi of one-sided
    spectra.
    """
    waves = shaping_filter(sea_spectrum(sea), form=sea.filter_form, states=sea.filter_states)
    if vessel.model == "direct":
        return boom_tip_model(waves, None)
    return boom_tip_model(waves, SecondOrderVessel(vessel.natural_frequency, vessel.damping_ratio, vessel.gain))


def mru_block(mru: MruModelParameters) -> LinearModel:
    """Return what the motion reference unit makes of the boom tip: its high-pass as two states, or none.

    reading = truth - e, e'' + 2 zeta w e' + w^2 e = 2 zeta w x0' + w^2 x0: the second-order high-pass, exactly.
    """
    inputs = ("boom_tip_heave", "boom_tip_heave_rate")
    through = {("mru_heave", inputs[0]): 1.0, ("mru_heave_rate", inputs[1]): 1.0}
    if mru.high_pass_period == 0.0:
        return linear_model(
            np.zeros((0, 0)),
            states=(),
            inputs={name: [] for name in inputs},
            outputs={"mru_heave": [], "mru_heave_rate": []},
            feedthrough=through,
        )
    cut_off = 2.0 * math.pi / mru.high_pass_period
    damping = 2.0 * mru.high_pass_damping * cut_off
    return linear_model(
        [[0.0, 1.0], [-(cut_off**2), -damping]],
        states=("mru_offset", "mru_offset_rate"),
        inputs={inputs[0]: [0.0, cut_off**2], inputs[1]: [0.0, damping]},
        outputs={"mru_heave": [-1.0, 0.0], "mru_heave_rate": [0.0, -1.0]},
        feedthrough=through,
    )


def slow_block(name: str, drift: float) -> LinearModel:
    """Return a slow state: a random walk of `drift` [unit/sqrt(s)] (depth bias, scale error)."""
    return linear_model([[0.0]], states=(name,), outputs={name: [1.0]}, noises={f"{name}_drift": [drift]})


@dataclass(frozen=True)
class ModelInputs:
    """All that the augmented model is made of.

    Attributes
    ----------
    cable, winch, sea, vessel : the plant and what moves it
    cable_disturbance : white acceleration of the unit [m/s^2/sqrt(Hz)]
    mru : the motion reference unit; None: no MRU states
    slow : slow states by name, with their drift [unit/sqrt(s)]
    """

    cable: CableModel
    winch: WinchModelParameters
    sea: SeaModelParameters
    vessel: VesselModelParameters
    cable_disturbance: float = 0.0
    mru: MruModelParameters | None = None
    slow: tuple[tuple[str, float], ...] = ()


def continuous_model(inputs: ModelInputs) -> LinearModel:
    """Return the connected continuous model without the command delay (thesis Eq. 6.28 and more)."""
    blocks = [
        cable_block(inputs.cable, inputs.cable_disturbance),
        winch_block(inputs.winch),
        boom_tip_block(inputs.sea, inputs.vessel),
        outlet_block(),
    ]
    if inputs.mru is not None:
        blocks.append(mru_block(inputs.mru))
    blocks += [slow_block(name, drift) for name, drift in inputs.slow]
    return interconnect(blocks)


def command_name(winch: WinchModelParameters) -> str:
    """Return the name of the command input: payout_rate_command, or payout_command for a first-order winch."""
    return PAYOUT_COMMAND if winch.law == "first_order" else RATE_COMMAND


def augmented_model(inputs: ModelInputs, tick_period: float) -> LinearModel:
    """Return the sampled model at ticks with the exact command delay; one input, the command of the tick.

    States: unit, payout, boom tip (vessel, waves), MRU high-pass, slow states, and past commands `<command>_1` (the
    newest) on.
    """
    model = continuous_model(inputs)
    return delay_command(model, tick_period, inputs.winch.command_delay, [command_name(inputs.winch)])


def sea_noise_covariance(inputs: ModelInputs, tick_period: float, order: int) -> Array:
    """Return the waves' share of the process noise of a tick of `augmented_model`, which has `order` states."""
    model = continuous_model(inputs)
    waves = [i for i, name in enumerate(model.noise_names) if name == "waves"]
    only_waves = replace(model, G=model.G[:, waves], noise_names=("waves",))
    covariance = sampled_matrices(only_waves, tick_period)[2]
    return np.pad(covariance, (0, order - model.order))


def taylor_delay_block(delay: float, input_name: str, output_name: str) -> LinearModel:
    """Return thesis Eq. 6.13: the delay by a second-order Taylor series of 1/e^(-s tau). For comparison only."""
    if delay <= 0.0:
        raise ModelError(f"a delay block needs a positive delay; got {delay:g} s")
    return linear_model(
        [[0.0, 1.0], [-2.0 / delay**2, -2.0 / delay]],
        states=(f"{output_name}_0", f"{output_name}_1"),
        inputs={input_name: [0.0, 2.0 / delay**2]},
        outputs={output_name: [1.0, 0.0]},
    )


def pade_delay_block(delay: float, order: int, input_name: str, output_name: str) -> LinearModel:
    """Return the Pade approximation order/order of the delay. For comparison only."""
    import control  # noqa: PLC0415  # heavy, and only the design report compares delays

    if delay <= 0.0 or order < 1:
        raise ModelError(f"a Pade block needs a positive delay and order; got {delay:g} s, {order}")
    numerator, denominator = control.pade(delay, order)
    system = control.tf2ss(control.tf(numerator, denominator))
    return linear_model(
        system.A,
        states=tuple(f"{output_name}_{i}" for i in range(order)),
        inputs={input_name: system.B[:, 0]},
        outputs={output_name: system.C[0]},
        feedthrough={(output_name, input_name): float(system.D[0, 0])},
    )


def shadow_model(cable: CableModel, tick_period: float) -> LinearModel:
    """Return the sampled uncompensated unit: boom_tip_heave and its rate in, unit_uncompensated_heave out.

    The boom tip moves straight within a tick. It makes the guard's and the display's "what the unit would do".
    """
    ramp = linear_model(
        [[0.0, 1.0], [0.0, 0.0]],
        states=("tip", "tip_rate"),
        inputs={"boom_tip_heave": [0.0, 0.0], "boom_tip_heave_rate": [0.0, 0.0]},
        outputs={"tip": [1.0, 0.0]},
    )
    unit = cable_block(cable)
    joined = interconnect([replace(unit, input_names=("tip", "payout")), ramp])
    sampled = discretise(joined, tick_period)
    return linear_model(
        sampled.A[:2, :2],
        states=("unit_uncompensated_heave", "unit_uncompensated_heave_rate"),
        inputs={"boom_tip_heave": sampled.A[:2, 2], "boom_tip_heave_rate": sampled.A[:2, 3]},
        outputs={"unit_uncompensated_heave": [1.0, 0.0], "unit_uncompensated_heave_rate": [0.0, 1.0]},
        dt=tick_period,
    )
