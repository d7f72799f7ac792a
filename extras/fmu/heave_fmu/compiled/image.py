"""What a scenario fills of the controller without Python: the records of a controller as C++ initialises them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from heave_bringup.closed_loop import LoopParameters
from heave_core import layout
from heave_core.filter import LEAST_USED
from heave_core.law import ACTING
from heave_core.library import dtype_of
from heave_node.parameters import ParameterError
from winch_controller_node.core.component import WinchController
from winch_controller_node.core.estimation.loop_estimation import NEAR
from winch_controller_node.core.supervision.supervisor import guarded_loop
from winch_controller_node.interface.sensors import DEPTH_BIAS
from winch_controller_node.laws.core_law import CoreLaw, StateFeedback
from winch_controller_node.motion.mean_motion import RETURN_SPEED

READINGS_MOST = 16
"""Most readings of a tick."""

_TREND_TIME = 30.0
"""Time over which the trends of landing are looked at, at most [s]."""

_C_NAMES = {dtype_of(one): one.name for one in layout.STRUCTURES}


def made_controller(parameters: LoopParameters) -> WinchController:
    """Return the controller of a loop with these `parameters`, for its image.

    Raises ParameterError for one that cannot go on without Python.
    """
    controller = parameters.controller
    core = WinchController(controller, tick_period=parameters.tick_period)
    law = core._in_force.law
    if not isinstance(law, CoreLaw) or law.preview is not None:
        raise ParameterError(
            f"law {controller.law} is made in Python, or uses a preview of the sea: --set winch_controller.law=lqg"
        )
    if controller.crane.is_fitted:
        raise ParameterError("a crane that moves stands in front of the controller: --set system.crane.fitted=false")
    if controller.programme.move_times or controller.programme.mode_times:
        raise ParameterError("moves and modes of a programme are requests, and nobody makes them there: leave it out")
    leave_out_plans(core)
    return core


def leave_out_plans(core: WinchController) -> None:
    """Let the law of a controller, `core`, make no plan at the limits of the winch.

    Its guard then takes it for one that does not keep them, and allows the authority whose peaks they hold.
    """
    law = core._in_force.law
    if isinstance(law, StateFeedback):
        law.stay_linear()
    core._supervisor.guard.take_loop(replace(guarded_loop(core.design, law), keeps_limits=False))


def records_of(core: WinchController) -> dict[str, Any]:
    """Return the arrays and numbers that the image of a controller, `core`, holds, by their names in C++."""
    acting, supervisor, design = core._control.records(ACTING), core._supervisor, core.design
    model, winch, bias = design.model, core.parameters.winch, design.parameters.sensors.depth.bias_sigma
    parameters = core.parameters
    rest = np.zeros(model.order)
    held = 1.0 if winch.law == "first_order" else winch.position_gain
    rest[[name.startswith(f"{model.input_names[0]}_") for name in model.state_names]] = held
    rest[model.state("payout")], rest[model.state("unit_heave")] = 1.0, -1.0
    return {
        **{name: acting[name] for name in ("winch", "law", "motion", "place", "load")},
        **{"command": acting["design"], "command_state": acting["state"], "envelope": core.envelope._core.design},
        **{
            "sense": core.observer.design,
            "filter": core.estimator.kalman.design,
            "look": core._estimation._look.design,
        },
        **{"guard": supervisor.guard.core.design, "attempts": supervisor.guard.core.attempt_design},
        **{"landing": supervisor.landing.core.design, "supervision": supervisor._design},
        **{"modes": core.modes.design, "mode": core.modes.state, "winch_watch": core._winch._core.design},
        "proofs": core.proofs.design,
        "A": model.A,
        "B": model.B[:, 0],
        "quiet_noise": model.noise_covariance - design.sea_noise,
        "sea_noise": design.sea_noise,
        "rest_state": rest,
        "near": NEAR,
        "return_speed": RETURN_SPEED,
        "active": core._control.active,
        "bias_variance": bias**2,
        "depth_bias": model.state(DEPTH_BIAS) if model.has_state(DEPTH_BIAS) else -1,
        "has_envelope": int(parameters.envelope.active),
        "consent": int(core.proofs.consent),
    }


def sizes_of(core: WinchController, records: Mapping[str, Any]) -> dict[str, int]:
    """Return the sizes of arrays that a controller, `core`, with these `records` needs, by their names in C++."""
    n, dt = core.design.model.order, core.design.tick_period
    guard, proofs, law, watch = (records[name][0] for name in ("guard", "proofs", "law", "winch_watch"))
    kept, plan = int(records["filter"]["kept"][0]), int(law["ends"][-1])
    return {
        "STATES": n,
        "PAST": kept * n * (n + 3) // 2,
        "PAST_TICKS": kept,
        "USED": kept * LEAST_USED * int(records["filter"]["measurements"][0]),
        "KNOTS": 2 + math.ceil(float(guard["first_look"]) / float(guard["knot_ticks"])),
        "PLAN_ROWS": max(plan, 1),
        "PLAN_NUMBERS": max(plan * n, 1),
        "TENSION_TICKS": int(records["command_state"]["tension"]["record"]["kept"][0]) + 1,
        "ALONE_STATES": 1,
        "REMEMBERED": math.ceil(_TREND_TIME / dt),
        "TRAVELS": int(records["sense"]["steps"]["travel_ticks"][0]),
        "UNIT_PAST": int(records["supervision"]["past"][0]),
        "PROOF_TICKS": int(proofs["kept"]),
        "PROOF_READINGS": 2 * int(proofs["kept"]),
        "FALL_TICKS": 2 * int(proofs["fall_ticks"]),
        "DRUM_ROWS": int(watch["drum"]["kept"]),
        "MINUTE": int(watch["link"]["minute"] + watch["link"]["window"]),
        "READINGS_MOST": READINGS_MOST,
    }


def image_header(records: Mapping[str, Any]) -> str:
    """Return `image.h`: the `records` of a controller, to the last bit."""
    declared = [f"    {_declared(name, value)};" for name, value in records.items()]
    values = [f"    {_initialiser(value)},  // {name}" for name, value in records.items()]
    return "\n".join(
        [
            "// What a scenario fills of the controller.",
            '#pragma once\n\n#include <cmath>\n\n#include "layout.h"\n\nnamespace heave {\n\nstruct Image {',
            *declared,
            "};\n\nstatic const Image IMAGE = {",
            *values,
            "};\n\n}  // namespace heave\n",
        ]
    )


def _declared(name: str, value: Any) -> str:
    if isinstance(value, np.ndarray):
        kind = _C_NAMES.get(value.dtype)
        return f"{kind} {name}" if kind else f"double {name}[{value.size}]"
    return f"{'int' if isinstance(value, int) else 'double'} {name}"


def _initialiser(value: Any) -> str:
    """Return a number, an array or a structured record as C++ initialises it; zeros at an array's end are left out."""
    if isinstance(value, np.ndarray):
        if value.dtype.names and value.shape == (1,):
            return _initialiser(value[0])
        flat = value.ravel()
        used = np.flatnonzero(flat.view(np.uint8).reshape(len(flat), -1).any(axis=1))
        return f"{{{', '.join(map(_initialiser, flat[: used[-1] + 1 if len(used) else 0]))}}}"
    if isinstance(value, np.void):
        return f"{{{', '.join(_initialiser(value[name]) for name in value.dtype.names or ())}}}"
    return str(int(value)) if isinstance(value, int | np.integer) else _number(float(value))


def _number(value: float) -> str:
    """Return a number as C++ reads it, to the last bit."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "-INFINITY" if value < 0.0 else "INFINITY"
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else value.hex()
