"""Identification of a scenario's cable: from a simulated response, from the linearised plant, and against length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from cable_sim_node.vertical.axial import simulate_axial
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import smooth_ramp
from winch_controller_node.design.bounds import boom_tip_realisation
from winch_controller_node.design.design import assumed_cable, assumed_plant
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.identification.cable import Identification, identify

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DURATION = 600.0
SAMPLE_PERIOD = 0.1
RAMP = 30.0
SHOWN = 200.0


@dataclass(frozen=True)
class LengthPoint:
    """What was identified at one deployed length, beside the linearised plant."""

    length: float  # deployed [m]
    identified: Identification  # from the simulated response
    linearised_a: float  # a of the linearised plant [s^2]
    linearised_b: float  # b of the linearised plant [s]


def identify_simulated(
    parameters: WinchControllerParameters, *, length: float | None = None, drag: str = "linear", seed: int = 1
) -> Identification:
    """Identify a and b as thesis 6.2.3 does: from the axial cable's response to a realisation of the design sea.

    The record of 600 s starts at rest and grows over 30 s; the winch is locked.

    Parameters
    ----------
    parameters : of plant and sea
    length : deployed length [m]; None: that of the parameters
    drag : "linear" or "quadratic"
    seed : of the sea

    Raises IdentificationError, or the AxialError of a response that cannot be simulated.
    """
    length = parameters.length if length is None else length
    plant = assumed_plant(parameters)
    tip = boom_tip_realisation(parameters.sea, parameters.vessel, duration=DURATION, step=SAMPLE_PERIOD, seed=seed)
    time = SAMPLE_PERIOD * np.arange(len(tip))
    tip = tip * np.array([smooth_ramp(float(t), RAMP)[0] for t in time])
    response = simulate_axial(plant.line(length), length, tip, SAMPLE_PERIOD, segments=20, largest_step=0.025)
    guess = assumed_cable(parameters, length)
    found = identify(
        time, tip, response.unit_heave, drag=drag, guess=(guess.a, max(guess.b, 0.01)), starts_at_rest=True
    )
    slack = float(np.mean(response.least_tension <= 0.0))
    if slack > 0.0:
        note = f"the cable was slack {100.0 * slack:.1f} % of the time: no linear model is valid there;  {found.note}"
        return replace(found, note=note.rstrip("; "))
    return found


def identify_against_length(
    parameters: WinchControllerParameters, lengths: Sequence[float], *, drag: str = "linear", seed: int = 1
) -> list[LengthPoint]:
    """Return a and b of the plant in `parameters` at each of `lengths` [m].

    `drag` and `seed` as for `identify_simulated`.
    """
    points = []
    for length in lengths:
        cable = assumed_cable(parameters, length)
        found = identify_simulated(parameters, length=length, drag=drag, seed=seed)
        points.append(LengthPoint(length, found, cable.a, cable.b))
    return points


def format_lengths(points: Sequence[LengthPoint]) -> str:
    """Return the `points` of `identify_against_length` as a table."""
    lines = ["length m    a s2   sigma       b   sigma   fit %   linearised a s2      b s"]
    for point in points:
        found = point.identified
        sigma = np.sqrt(np.diag(found.covariance))
        lines.append(
            f"{point.length:8.1f} {found.a:7.4f} {sigma[0]:7.4f} {found.b:7.4f} {sigma[1]:7.4f} "
            f"{100.0 * found.fit:7.2f} {point.linearised_a:17.4f} {point.linearised_b:8.4f}"
        )
    return "\n".join(lines)


def draw_identification(found: Identification, path: Path) -> None:
    """Draw response, model and residual (thesis figs 6.11 to 6.13) of what was `found` to `path`."""
    figure = identification_figure(found)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)


def identification_figure(found: Identification) -> Figure:
    """Return the figure of what was `found`: measured and model of the last 200 s above, residual below."""
    from matplotlib.figure import Figure  # noqa: PLC0415  # heavy, and only for who draws

    shown: Array = found.time >= found.time[-1] - SHOWN
    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    above.plot(found.time[shown], found.measured[shown], label="response")
    above.plot(found.time[shown], found.model[shown], "--", label=f"model, {found.drag} drag")
    above.set_title(found.summary().replace("\n", "; "), fontsize=9)
    above.set_ylabel("load heave [m]")
    above.legend()
    below.plot(found.time[shown], (found.measured - found.model)[shown], color="0.3")
    below.set_ylabel("residual [m]")
    below.set_xlabel("time [s]")
    return figure
