"""The numbers of a design and the variables of an FMU as headers of C."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from heave_core.envelope_table import DESIGN, STATE
from heave_core.library import dtype_of, fill, new
from heave_node.numerics.arrays import Array
from heave_node.numerics.constants import ATMOSPHERIC_PRESSURE
from winch_controller_node.core.estimation.sense_design import ON_TICK
from winch_controller_node.core.loop_command import LEAK, REACH
from winch_controller_node.laws.parts.governor import drum_ahead
from winch_controller_node.model.estimator import row_with_differences
from winch_controller_node.model.loop_rows import loop_rows
from winch_controller_node.model.models import shadow_model

from heave_fmu.compiled.part import FixedControllerPart
from heave_fmu.variables import Variable


def interface_header(part: FixedControllerPart, variables: Sequence[Variable], inputs: int, guid: str) -> str:
    """Return `interface.h`: sizes, times, what a reading is of, and the variables by their references.

    Parameters
    ----------
    part : the controller, for its sizes
    variables : of the FMU, inputs first
    inputs : number of these
    guid : of the FMU
    """
    design = part.design
    largest_age = round(design.parameters.estimator.largest_age / part.tick_period)
    numbers = {
        "ORDER": design.model.order,
        "MEASUREMENTS": len(design.measurements),
        "KEPT": largest_age + 1,
        "TICK_PERIOD": part.tick_period,
        "INSTANT": part.instant,
        "ON_TICK": ON_TICK,
        "ATMOSPHERE": ATMOSPHERIC_PRESSURE,
        "PRESSURE_PER_METRE": part.water.pressure_per_metre,
        "VARIABLES": len(variables),
        "FIRST_OUTPUT": inputs,
    }
    lines = [_define(name, value) for name, value in numbers.items()]
    lines += [f'#define GUID "{guid}"', f'#define KINDS "{"".join(variable.kind[0] for variable in variables)}"']
    lines += [_enum(known.name.upper() for known in design.measurements)]
    lines += [_enum(variable.name.replace(".", "_") for variable in variables)]
    return "\n".join(["#ifndef HEAVE_INTERFACE_H", "#define HEAVE_INTERFACE_H", *lines, "#endif", ""])


def design_header(part: FixedControllerPart) -> str:
    """Return `design.h`: the numbers of the design of a fixed controller, `part`, to the last bit."""
    design, law, dt = part.design, part.law, part.tick_period
    model, winch, limits = design.model, design.parameters.winch, design.limits
    free = shadow_model(part.taut_cable, dt)
    modes, estimator, rows = design.parameters.modes, design.parameters.estimator, loop_rows(model)
    differences = np.array([row_with_differences(known.row, model) for known in design.measurements])
    scalars = {
        "UNIT": int(rows.unit_states[0]),
        "UNIT_RATE": int(rows.unit_states[1]),
        "CABLE_INERTIA": design.drag.inertia,
        "DRAG_DAMPING": design.drag.damping,
        "DRAG_QUADRATIC": design.drag.quadratic,
        "SLACK_LARGEST": design.slack.largest,
        "GATE": estimator.gate,
        "GATE_LIMIT": estimator.gate_limit,
        "SETTLING_TIME": modes.settling_time,
        "FADE_STEP": dt / modes.fade_in_time,
        "FACTOR": design.parameters.factor,
        "LARGEST_SHARE": law.largest_share,
        "SERVO_LAG": winch.time_constant,
        "LINEAR_STEP": float(law.winch.record["linear_step"][0]),
        "POSITION_GAIN": winch.position_gain,
        "SET_POINT_REACH": winch.set_point_reach,
        "CREEP": winch.creep,
        "SPEED_GAIN": winch.speed_gain,
        "HAULING_GAIN": winch.hauling_gain,
        "SPEED": limits.speed,
        "ACCELERATION": limits.acceleration,
        "PAYOUT_MINIMUM": limits.payout_minimum,
        "PAYOUT_MAXIMUM": limits.payout_maximum,
        "PLACE_LEAK": LEAK,
        "PLACE_REACH": REACH,
    }
    arrays = {
        "MODEL_F": model.A,
        "MODEL_B": model.B[:, 0],
        "MODEL_Q": model.noise_covariance,
        "INITIAL_P": design.initial_covariance,
        "SLACK_PULL": design.slack.pull,
        "ROWS": differences[:, 0],
        "CHANGES": differences[:, 1],
        "BENDS": differences[:, 2],
        "VARIANCES": np.array([known.sigma**2 for known in design.measurements]),
        "IS_GATED": np.array([float(known.is_gated) for known in design.measurements]),
        "IS_SEA": np.array([float(name in design.sea_states) for name in model.state_names]),
        "TIP": rows.tip,
        "DRUM_PAYOUT": rows.payout,
        "AHEAD": drum_ahead(model, winch),
        "GAIN": law.gain,
        "FREE_A": free.A,
        "FREE_B": free.B,
        "FREE_C": free.C,
        "FREE_D": free.D,
    }
    states = f"/* States: {', '.join(model.state_names)} */"
    lines = [states, *(_define(*one) for one in scalars.items()), *(_array(*one) for one in arrays.items())]
    return "\n".join([*lines, ""])


def bounds_header(part: FixedControllerPart) -> str:
    """Return `bounds.h`: the nominal design of the envelope of a fixed controller, `part`, to the last bit."""
    record = new(DESIGN)
    fill(record[0], part.nominal)
    numbers = dtype_of(STATE).itemsize // 8
    design = f"#define ENVELOPE_DESIGN {_initialiser(record[0])}"
    guard = "HEAVE_BOUNDS_H"
    lines = [f"#ifndef {guard}", f"#define {guard}", "#include <math.h>", _define("ENVELOPE_NUMBERS", numbers), design]
    return "\n".join([*lines, "#endif", ""])


def _initialiser(record: Any) -> str:
    """Return a structured `record` as C++ initialises it."""
    values = []
    for name in record.dtype.names:
        value = record[name]
        is_group = value.dtype.names is not None
        values.append(_initialiser(value) if is_group else str(value) if value.dtype.kind == "i" else _number(value))
    return f"{{{', '.join(values)}}}"


def _define(name: str, value: float) -> str:
    return f"#define {name} {value if isinstance(value, int) else _number(value)}"


def _number(value: float) -> str:
    """Return a number as C reads it, to the last bit."""
    return f"({float(value).hex()} /* {value:.9g} */)" if np.isfinite(value) else f"({'-' * (value < 0.0)}HUGE_VAL)"


def _enum(names: Iterable[str]) -> str:
    return f"enum {{ {', '.join(names)} }};"


def _array(name: str, values: Array) -> str:
    sizes = "".join(f"[{size}]" for size in values.shape)
    return f"static const double {name}{sizes} = {_braced(values)};"


def _braced(values: Array) -> str:
    inner = map(_braced, values) if values.ndim > 1 else (float(value).hex() for value in values)
    return "{" + (",\n " if values.ndim > 1 else ", ").join(inner) + "}"
