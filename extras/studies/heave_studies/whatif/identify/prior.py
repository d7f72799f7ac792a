"""What is known of cable, unit and MRU before the record: `--know cable.axial_stiffness=1.42e7+-2%`."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from heave_node.parameters import ParameterError
from winch_controller_node.node_parameters import WinchControllerParameters

INERTIA, DAMPING, CABLE_DRAG = "cable.inertia_factor", "cable.damping_factor", "cable.drag_factor"
STIFFNESS, SCALE, DELAY, LEVER_ARM = "cable.stiffness_factor", "mru.scale", "mru.delay", "mru.lever_arm"

AS_THEY_ARE = {DELAY: "s", LEVER_ARM: "m"}
"""Quantities that are 0 where all is as assumed, with their units; the others are factors."""

USUAL = {INERTIA: 0.15, DAMPING: 0.6, CABLE_DRAG: 0.3, STIFFNESS: 0.1, SCALE: 0.02, DELAY: 0.04, LEVER_ARM: 0.1}
"""Standard deviation of each about what is assumed: of the logarithm of a factor [-], of a delay [s] or an arm [m]."""

GIVEN = "cable.axial_stiffness"

MASS_PRIOR = 0.1
"""Standard deviation of the logarithm of the inertia where the stiffness is known: added mass is a guess."""

NUMBER = r"[-+]?[0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]+)?"
FORM = re.compile(rf"(?P<name>[a-z_.]+)=(?P<value>{NUMBER})\+-(?P<spread>{NUMBER})(?P<percent>%?)")

LEAST_SPREAD = 1e-4
"""Relative spread that nobody can state of a factor."""


class Prior(NamedTuple):
    """What is known before the record."""

    sigma: Mapping[str, float]  # standard deviation of each quantity, by name in USUAL
    centre: Mapping[str, float]  # and where it is: logarithm of a factor, the others as they are; 0 where none is given


def prior_of(nominal: WinchControllerParameters, texts: Iterable[str] = ()) -> Prior:
    """Return what is known before the record.

    Parameters
    ----------
    nominal : parameters of the controller, to whose stiffness a given one is compared
    texts : NAME=VALUE+-SPREAD, the spread one standard deviation, with % a relative one

    Raises ParameterError for another form or an unknown name.
    """
    mru = nominal.sensors.mru
    sigma = {
        **USUAL,
        SCALE: max(USUAL[SCALE], mru.scale_sigma),
        LEVER_ARM: max(USUAL[LEVER_ARM], mru.lever_arm_sigma),
    }
    centre = dict.fromkeys(USUAL, 0.0)
    for text in texts:
        name, value, spread = _parsed(text)
        if name == GIVEN:
            centre[STIFFNESS] = math.log(value / nominal.cable.axial_stiffness)
            centre[INERTIA] = -centre[STIFFNESS]
            sigma[STIFFNESS], sigma[INERTIA] = spread, math.hypot(spread, MASS_PRIOR)
        else:
            centre[name], sigma[name] = (value if name in AS_THEY_ARE else math.log(value)), spread
    return Prior(sigma, centre)


def _parsed(text: str) -> tuple[str, float, float]:
    """Return name, value and spread of a `text`: the spread of the logarithm of a factor, else in its unit."""
    found = FORM.fullmatch(text)
    allowed = (GIVEN, *USUAL)
    if found is None or found["name"] not in allowed:
        raise ParameterError(
            f"--know {text}: must be NAME=VALUE+-SPREAD, such as {GIVEN}=1.42e7+-2%, of {', '.join(allowed)}"
        )
    name, value, spread = found["name"], float(found["value"]), float(found["spread"])
    is_factor = name not in AS_THEY_ARE
    if found["percent"]:
        spread *= 0.01 if is_factor else 0.01 * abs(value)
    elif is_factor:
        spread /= abs(value or 1.0)
    if is_factor and 0.0 < spread < LEAST_SPREAD:
        raise ParameterError(f"--know {text}: a spread of {100.0 * spread:.2g} %: is +-{found['spread']}% meant?")
    if not (spread > 0.0 and (value > 0.0 or not is_factor)):
        raise ParameterError(f"--know {text}: value and spread must be above 0")
    return name, value, spread
