"""The lift as a drawing that moves: ship, winch, rope and load over the time of a run."""

from __future__ import annotations

import base64
import math
from typing import Any

import numpy as np
from heave_node.numerics.arrays import Array

from heave_bags.analyse import run_words
from heave_bags.analyse.reading.stored import number
from heave_bags.analyse.run_record import RunRecord
from heave_bags.signals import Signal

STEP = 0.5
"""Time between two samples of the drawing [s]: twelve in a wave of 6 s."""
MOST = 7200
"""Samples of a column at most, 2 bytes each: an hour; of a longer run the step is longer."""
REACH = 30.0
"""Largest motion in the drawing [pixels of its 480]."""
LARGEST_SCALE = 60.0
"""Largest scale of the drawing [pixels/m]: what hardly moves is not to look as if it did."""
DRUM_RADIUS = 1.0
"""Radius by which the drawn drum turns [m]."""
USUAL_SIDE, LEAST_SIDE, MOST_SIDE = 12.0, 14.0, 40.0
"""Side of a load of 1 m^3, and limits of the side of any [pixels]."""


def lift_drawing(record: RunRecord) -> dict[str, Any] | None:
    """Return what the page draws of the run `record`: words, sizes, and the motions as packed columns; None: it
    recorded no load.

    Lengths are in metres, heave positive up, payout positive out.
    """
    signals = record.signals
    named = {
        "tip": signals.boom_tip_heave,
        "load": signals.unit_heave,
        "locked": signals.uncompensated_heave,
        "payout": signals.payout,
    }
    known = {name: signal for name, signal in named.items() if signal.size > 1}
    if "load" not in known:
        return None
    start, end = float(known["load"].time[0]), float(known["load"].time[-1])
    step = max(STEP, (end - start) / MOST)
    time = np.arange(start, end, step)
    columns = {name: _about_mean(signal, time, record.start) for name, signal in known.items()}
    largest = max(float(np.abs(columns[name]).max()) for name in columns if name != "payout")
    plant = record.parameters.get("cable_sim", {})
    volume, diameter = number(plant, "unit.volume", math.nan), number(plant, "cable.diameter", math.nan)
    side = USUAL_SIDE * volume ** (1.0 / 3.0) if volume > 0.0 else USUAL_SIDE * 2.0
    facts = run_words.facts(record)
    return {
        "load": facts["load"].split(", ") if "load" in facts else ["load"],
        "rope": f"{1e3 * diameter:.3g} mm rope" if math.isfinite(diameter) else "",
        "length": f"{number(plant, 'length', math.nan):g} m" if "length" in plant else "",
        "side": round(min(max(side, LEAST_SIDE), MOST_SIDE), 1),
        "has_locked": "locked" in columns,
        "motion": {
            "start": start,
            "step": step,
            "count": len(time),
            "first": record.start,
            "scale": min(REACH / largest, LARGEST_SCALE) if largest > 0.0 else LARGEST_SCALE,
            "radius": DRUM_RADIUS,
            "columns": {name: _packed(values) for name, values in columns.items()},
            "modes": [[mode.start, mode.name] for mode in record.modes],
        },
    }


def _about_mean(signal: Signal, time: Array, settled: float) -> Array:
    """Return a signal at the times of the drawing, about its mean once the run is `settled` [s]."""
    counted = signal.value[signal.time >= settled]
    mean = float(counted.mean()) if counted.size else float(signal.value.mean())
    return np.nan_to_num(np.interp(time, signal.time, signal.value - mean))


def _packed(values: Array) -> dict[str, Any]:
    """Return `values` as whole numbers of 16 bits and their unit."""
    unit = max(float(np.abs(values).max()) / 32767.0, 1e-9)
    data = np.rint(values / unit).astype("<i2").tobytes()
    return {"unit": unit, "int16": base64.b64encode(data).decode("ascii")}
