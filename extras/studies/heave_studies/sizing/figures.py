"""The figure of a sizing study, as plain data for the report's script."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from heave_bags.report.figure import LIMIT, OTHER, UNIT, Figure

from heave_studies.sizing.candidates import Particular
from heave_studies.sizing.study import Knee, Sized, sweep_of


def sweep_figure(found: Sequence[Sized], knee: Knee) -> Figure:
    """Return what a particular is worth: workable seas over its values, with the knee.

    Parameters
    ----------
    found : winches of a study, the scenario's own first
    knee : of the particular
    """
    particular = knee.particular
    sweep = [one for one in sweep_of(found, particular) if math.isfinite(one.winch.value(particular))]
    values = [particular.scale * one.winch.value(particular) for one in sweep]
    shares = [100.0 * one.share for one in sweep]
    spread = {
        "type": "data",
        "symmetric": False,
        "array": [100.0 * (one.upper - one.share) for one in sweep],
        "arrayminus": [100.0 * (one.share - one.lower) for one in sweep],
        "color": UNIT,
    }
    traces = [_line("workable seas", values, shares, UNIT, error_y=spread)]
    if math.isfinite(knee.value) and not knee.is_open:
        traces.append(_upright("knee", particular.scale * knee.value, LIMIT, "dash"))
    own = found[0].winch.value(particular)
    if math.isfinite(own):
        traces.append(_upright("the scenario's", particular.scale * own, OTHER, "dot"))
    return Figure(
        f"What {particular.name} is worth",
        _caption(found, particular),
        traces,
        {
            "xaxis": {"title": {"text": particular.heading}, "rangemode": "tozero"},
            "yaxis": {"title": {"text": "workable [%]"}, "range": [0, 105]},
            "hovermode": "closest",
        },
        is_over_time=False,
        height=340,
    )


def _caption(found: Sequence[Sized], particular: Particular) -> str:
    words = "Everything else as the scenario has it."
    unlimited = [one for one in sweep_of(found, particular) if math.isinf(one.winch.value(particular))]
    return words + "".join(f" Without a limit {100.0 * one.share:.1f} % are workable." for one in unlimited)


def _line(name: str, x: Sequence[float], y: Sequence[float], colour: str, **more: Any) -> dict[str, Any]:
    line = {"color": colour, "width": 2.5}
    return {"name": name, "x": list(x), "y": list(y), "mode": "lines+markers", "line": line, **more}


def _upright(name: str, x: float, colour: str, dash: str) -> dict[str, Any]:
    line = {"color": colour, "width": 1.5, "dash": dash}
    hover = f"{name}: {x:.3g}<extra></extra>"
    return {"name": name, "x": [x, x], "y": [0, 105], "mode": "lines", "line": line, "hovertemplate": hover}
