"""What an engineer knows better than the parameters: `--know cable.axial_stiffness=1.42e7+-2%`."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable

from heave_node.parameters import ParameterError
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_bringup.whatif.identify.cable import DELAY, INERTIA, PRIOR

STIFFNESS = "cable.axial_stiffness"

MASS_PRIOR = 0.1
"""Standard deviation of the logarithm of the inertia where the stiffness is known: added mass is a guess."""

NUMBER = r"[-+]?[0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]+)?"
FORM = re.compile(rf"(?P<name>[a-z_.]+)=(?P<value>{NUMBER})\+-(?P<spread>{NUMBER})(?P<percent>%?)")

Told = tuple[dict[str, float], dict[str, float]]


def parse_known(texts: Iterable[str], nominal: WinchControllerParameters) -> Told:
    """Return standard deviations and centres of what is known before the record, by name in PRIOR.

    Parameters
    ----------
    texts : NAME=VALUE+-SPREAD, the spread one standard deviation, with % a relative one
    nominal : parameters of the controller, to whose stiffness a given one is compared

    Raises ParameterError for another form or an unknown name.
    """
    prior, centre = dict(PRIOR), {}
    for text in texts:
        found = FORM.fullmatch(text)
        allowed = (STIFFNESS, *PRIOR)
        if found is None or found["name"] not in allowed:
            raise ParameterError(
                f"--know {text}: must be NAME=VALUE+-SPREAD, such as {STIFFNESS}=1.42e7+-2%, of {', '.join(allowed)}"
            )
        name, value, spread = found["name"], float(found["value"]), float(found["spread"])
        spread = 0.01 * spread if found["percent"] else spread if name == DELAY else spread / abs(value or 1.0)
        if not (spread > 0.0 and (value > 0.0 or name == DELAY)):
            raise ParameterError(f"--know {text}: value and spread must be above 0")
        if name == STIFFNESS:
            centre[INERTIA] = math.log(nominal.cable.axial_stiffness / value)
            prior[INERTIA] = math.hypot(spread, MASS_PRIOR)
        else:
            centre[name], prior[name] = (value if name == DELAY else math.log(value)), spread
    return prior, centre
