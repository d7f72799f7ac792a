"""A design as named arrays and texts, and back: what travels in a message, exact to the bit.

What comes over the wire is not trusted: every name, shape, number and parameter is checked before a design is made of
it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass, fields

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel
from heave_node.parameters import build_parameters, flatten

from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.laws.registry import law_class
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.estimator import MeasurementModel
from winch_controller_node.model.lqr import QuadraticCost
from winch_controller_node.node_parameters import WinchControllerParameters

CABLE = tuple(field.name for field in fields(CableModel))
MATRICES = ("A", "B", "C", "D", "G")
NAMES = ("state_names", "input_names", "output_names", "noise_names")
MAY_BE_INFINITE = ("cable.unit_weight",)
"""Arrays whose numbers need not be finite: a unit whose weight is not known never lets the cable go slack."""

NO_STATE = -1.0
"""Scale state of a measurement without one."""

_TEXTS = (
    "parameters",
    *(f"model.{name}" for name in NAMES),
    "sigma",
    "own_gains",
    "measurements.name",
    "measurements.sensor",
)


class WireError(ValueError):
    """A design that cannot be made of what came; one line that names the part that is wrong."""


@dataclass(frozen=True, eq=False)
class DesignParts:
    """A design in parts."""

    arrays: Mapping[str, Array]  # float64, by name; SI units, heave positive up, payout positive lowers the unit
    texts: Mapping[str, Sequence[str]]  # by name; `parameters` is one JSON object by dotted name


def parts_of(design: ControllerDesign) -> DesignParts:
    """Return a `design` in parts, of which `design_of` makes one that equals it to the bit."""
    model, cost, measurements = design.model, design.cost, design.measurements
    order = model.order
    arrays = {
        "tick_period": np.array(design.tick_period),
        "length": np.array(design.length),
        **{f"cable.{name}": np.array(value) for name, value in zip(CABLE, astuple(design.cable), strict=True)},
        **{f"model.{name}": getattr(model, name) for name in MATRICES},
        "model.dt": np.array(math.nan if model.dt is None else model.dt),
        "initial_covariance": design.initial_covariance,
        "gain": design.gain,
        "cost.Q": cost.Q,
        "cost.N": cost.N,
        "cost.R": cost.R,
        "sigma": np.array(list(design.sigma.values())),
        "sea_noise": design.sea_noise,
        "own_gains": np.array(list(design.own_gains.values())).reshape(len(design.own_gains), order),
        "measurements.row": np.array([one.row for one in measurements]).reshape(len(measurements), order),
        "measurements.sigma": np.array([one.sigma for one in measurements]),
        "measurements.scale_state": np.array(
            [NO_STATE if one.scale_state is None else one.scale_state for one in measurements]
        ),
        "measurements.is_gated": np.array([one.is_gated for one in measurements]),
    }
    texts = {
        "parameters": (parameters_text(design.parameters),),
        **{f"model.{name}": getattr(model, name) for name in NAMES},
        "sigma": tuple(design.sigma),
        "own_gains": tuple(design.own_gains),
        "measurements.name": tuple(one.name for one in measurements),
        "measurements.sensor": tuple(one.sensor for one in measurements),
    }
    return DesignParts({name: np.asarray(value, dtype=float) for name, value in arrays.items()}, texts)


def design_of(parts: DesignParts) -> ControllerDesign:
    """Return the design that `parts` hold.

    Raises WireError, naming the part, for one that is missing, unknown, of a wrong shape or not finite, and for
    parameters that no controller may have.
    """
    texts = {name: tuple(values) for name, values in parts.texts.items()}
    _check_names("text", texts, _TEXTS)
    _check_shapes(parts.arrays, texts)
    for name, array in parts.arrays.items():
        if name not in MAY_BE_INFINITE and not np.all(np.isfinite(array)):
            raise WireError(f"design: {name} holds a value that is not finite")
    arrays = {name: np.array(array, dtype=float, order="C") for name, array in parts.arrays.items()}
    if len(texts["parameters"]) != 1:
        raise WireError(f"design: parameters must be one text; got {len(texts['parameters'])}")
    parameters = parameters_of(texts["parameters"][0])
    if texts["own_gains"] not in ((), law_class(parameters.law).gain_names):
        raise WireError(f"design: own_gains are not those of law {parameters.law}: {', '.join(texts['own_gains'])}")
    try:
        A, B, C, D, G = (arrays[f"model.{name}"] for name in MATRICES)
        states, inputs, outputs, noises = (texts[f"model.{name}"] for name in NAMES)
        model = LinearModel(A, B, C, D, G, states, inputs, outputs, noises, dt=float(arrays["model.dt"]))
        cable = CableModel(*(float(arrays[f"cable.{name}"]) for name in CABLE))
    except ValueError as error:
        raise WireError(f"design: {error}") from error
    return ControllerDesign(
        parameters=parameters,
        tick_period=float(arrays["tick_period"]),
        length=float(arrays["length"]),
        cable=cable,
        model=model,
        measurements=_measurements(arrays, texts, model.order),
        initial_covariance=arrays["initial_covariance"],
        gain=arrays["gain"],
        cost=QuadraticCost(arrays["cost.Q"], arrays["cost.N"], arrays["cost.R"]),
        sigma=dict(zip(texts["sigma"], arrays["sigma"].tolist(), strict=True)),
        sea_noise=arrays["sea_noise"],
        own_gains=dict(zip(texts["own_gains"], arrays["own_gains"], strict=True)),
    )


def parameters_text(parameters: WinchControllerParameters) -> str:
    """Return all `parameters` as one JSON object by dotted name; numbers keep every bit."""
    return json.dumps(flatten(parameters))


def parameters_of(text: str) -> WinchControllerParameters:
    """Return the parameters of a `text` as `parameters_text` gives it; each must be there, and within its range.

    Raises WireError for any other text.
    """
    try:
        values = json.loads(text)
    except ValueError as error:
        raise WireError(f"parameters: no JSON: {error}") from error
    if not isinstance(values, dict):
        raise WireError("parameters: no JSON object")
    missing = sorted(flatten(WinchControllerParameters()).keys() - values.keys())
    if missing:
        raise WireError(f"parameters: {missing[0]} is missing")
    try:
        return build_parameters(WinchControllerParameters, values, where="parameters")
    except ValueError as error:
        raise WireError(str(error)) from error


def _check_names(kind: str, given: Mapping[str, object], known: Sequence[str]) -> None:
    missing, unknown = sorted(set(known) - given.keys()), sorted(given.keys() - set(known))
    if missing or unknown:
        raise WireError(f"design: {kind} {missing[0]} is missing" if missing else f"design: no {kind} {unknown[0]}")


def _check_shapes(arrays: Mapping[str, Array], texts: Mapping[str, tuple[str, ...]]) -> None:
    """Hold every array against the number of names that it goes with."""
    n, m, p, q = (len(texts[f"model.{name}"]) for name in NAMES)
    measured, known = len(texts["measurements.name"]), len(texts["sigma"])
    square, column = (n, n), (measured,)
    shapes: dict[str, tuple[int, ...]] = {
        "tick_period": (),
        "length": (),
        **{f"cable.{name}": () for name in CABLE},
        **dict(zip((f"model.{name}" for name in MATRICES), (square, (n, m), (p, n), (p, m), (n, q)), strict=True)),
        "model.dt": (),
        "initial_covariance": square,
        "gain": (n,),
        "cost.Q": square,
        "cost.N": (n, m),
        "cost.R": (m, m),
        "sigma": (known,),
        "sea_noise": square,
        "own_gains": (len(texts["own_gains"]), n),
        "measurements.row": (measured, n),
        "measurements.sigma": column,
        "measurements.scale_state": column,
        "measurements.is_gated": column,
    }
    _check_names("array", arrays, tuple(shapes))
    for name, shape in shapes.items():
        if arrays[name].shape != shape:
            raise WireError(f"design: {name} must have shape {shape}; got {arrays[name].shape}")
    if len(texts["measurements.sensor"]) != measured:
        raise WireError(f"design: {measured} measurements, but {len(texts['measurements.sensor'])} sensors")
    if m != 1 or len(set(texts["measurements.name"])) != measured or len(set(texts["sigma"])) != known:
        raise WireError("design: it must have one input, and no measurement and no sigma twice")
    if len(set(texts["own_gains"])) != len(texts["own_gains"]):
        raise WireError("design: it must have no gain of a name twice")


def _measurements(
    arrays: Mapping[str, Array], texts: Mapping[str, tuple[str, ...]], order: int
) -> tuple[MeasurementModel, ...]:
    scales, gates = arrays["measurements.scale_state"], arrays["measurements.is_gated"]
    for name, values, allowed in (
        ("measurements.scale_state", scales, [NO_STATE, *range(order)]),
        ("measurements.is_gated", gates, [0.0, 1.0]),
    ):
        if not np.all(np.isin(values, allowed)):
            raise WireError(f"design: {name} holds a value that it cannot have: {values.tolist()}")
    return tuple(
        MeasurementModel(
            name,
            texts["measurements.sensor"][i],
            arrays["measurements.row"][i],
            float(arrays["measurements.sigma"][i]),
            None if scales[i] == NO_STATE else int(scales[i]),
            bool(gates[i]),
        )
        for i, name in enumerate(texts["measurements.name"])
    )
