"""Changes to a scenario that a user requests: `--set NODE.PARAM=VALUE`, options of a command, cases of a campaign."""

from __future__ import annotations

import difflib
from dataclasses import dataclass

import yaml
from heave_node.parameters import ParameterError
from heave_node.scenario import WILDCARD, parse_yaml

from heave_bringup.nodes import NODE_BY_NAME

EVERY_NODE = "all"
"""What stands for every node on the command line, where a shell would take `/**` for files."""
SHARED = ("system", "wanted")
"""Groups under `/**`, so that the command line needs no node before them."""


@dataclass(frozen=True)
class Setting:
    """One change: a parameter, its new value, and where the change comes from.

    Attributes
    ----------
    target : node, or `/**` for what all nodes share
    name : dotted name of the parameter
    value : not yet checked
    source : what the user wrote, to be named where the value is wrong
    """

    target: str
    name: str
    value: object
    source: str


def make_setting(place: str, value: object, source: str) -> Setting:
    """Return a change of a parameter.

    Parameters
    ----------
    place : of the parameter: `wave_vessel.peak_period`, `system.sea.peak_period`, `wanted.kappa`, `all.seed`
    value : not yet checked
    source : what the user wrote; it opens error messages

    Raises ParameterError, in one line, for a place that names no node or no parameter.
    """
    first, _, rest = place.partition(".")
    if not rest:
        raise ParameterError(
            f"{source}: {place} is not a parameter; write NODE.PARAM or system.PARAM, for example "
            "system.sea.peak_period"
        )
    if first in SHARED:
        return Setting(WILDCARD, place, value, source)
    if first in (EVERY_NODE, WILDCARD):
        return Setting(WILDCARD, rest, value, source)
    if first in NODE_BY_NAME:
        return Setting(first, rest, value, source)
    known = (*SHARED, EVERY_NODE, *NODE_BY_NAME)
    near = difflib.get_close_matches(first, known, n=1)
    hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(known)}"
    raise ParameterError(f"{source}: no such node: {first}; {hint}")


def parse_setting(text: str) -> Setting:
    """Return the change that the `text` of a `--set` option requests: PLACE=VALUE, the value in YAML.

    Raises ParameterError for another form.
    """
    place, separator, value = text.partition("=")
    source = f"--set {text}"
    if not separator:
        raise ParameterError(f"{source}: must be NODE.PARAM=VALUE, for example system.sea.peak_period=9")
    try:
        return make_setting(place, parse_yaml(value), source)
    except yaml.YAMLError as error:
        raise ParameterError(f"{source}: {value!r} is not a YAML value") from error
