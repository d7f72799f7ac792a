"""Changes to a scenario that a user requests: `--set NODE.PARAM=VALUE`, options of a command, cases of a campaign.

And where else a parameter is that somebody gave to the wrong node, or without the group before its name.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache

from heave_node.files.bounded_yaml import YamlError, parse_yaml
from heave_node.parameters import ParameterError, describe
from heave_node.run_parameters import RunParameters
from heave_node.scenario import WILDCARD
from heave_node.system_parameters import SYSTEM, owned_names

from heave_bringup.nodes import ENVELOPE, NODE_BY_NAME, NODES

EVERY_NODE = "all"
"""Name of all nodes on the command line, where a shell would expand `/**` to files."""
SHARED = ("system", "wanted")
"""Groups under `/**`, so that the command line needs no node before them."""
MOST_PLACES = 3
"""Most places that are named where a parameter stands elsewhere."""


@dataclass(frozen=True)
class Setting:
    """One change: a parameter, its new value, and where the change comes from."""

    target: str  # node, or `/**` for what all nodes share
    name: str  # dotted name of the parameter
    value: object  # not yet checked
    source: str  # what the user wrote, to be named where the value is wrong

    @property
    def place(self) -> str:
        """Where the parameter is: with its node before it, unless all nodes share it."""
        return self.name if self.target == WILDCARD else f"{self.target}.{self.name}"


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
    except YamlError as error:
        raise ParameterError(f"{source}: {value!r} is not a YAML value: {error}") from error


def plain_settings(texts: Iterable[str]) -> dict[str, object]:
    """Return the value of each place that the `texts` of `--set` options change, as the cases of a campaign take it.

    Raises ParameterError, in one line, for what parse_setting refuses, and for a value that is no YAML.
    """
    values = {}
    for text in texts:
        parse_setting(text)
        place, _, value = text.partition("=")
        values[place] = yaml_value(value, f"--set {text}")
    return values


def yaml_value(text: str, source: str) -> object:
    """Return the YAML value that a `text` is, with `off` as a word; raise ParameterError, naming its `source`, else."""
    try:
        return parse_yaml(text, only_true_and_false=True)
    except YamlError as error:
        raise ParameterError(f"{source}: {text!r} is not a YAML value: {error}") from error


def near_places(target: str, name: str) -> list[str]:
    """Return where there is a parameter `name`, dotted, that the `target` does not know, with or without a group before
    it.

    First comes the target itself, a node or `/**` for what all nodes share, then other nodes, those first whose name is
    the most alike.
    """
    found = [(where, of, _alike(of, name)) for where, of in _places() if _alike(of, name)]
    own = [(where, of, alike) for where, of, alike in found if where == target]
    own = [one for one in own if one[2] == max(alike for *_, alike in own)]
    nodes = [one for one in found if one[0] not in (target, WILDCARD)]
    same = [one for one in nodes if one[1] == name]
    others = [] if target == WILDCARD and own else same if own or same else nodes
    reported = [*own, *sorted(others, key=lambda one: -one[2])]
    return [of if where == WILDCARD else f"{where}.{of}" for where, of, _ in reported[:MOST_PLACES]]


def meant(places: Sequence[str]) -> str:
    """Return the question whether one of the `places` was meant."""
    return f"did you mean {' or '.join(places)}?"


@cache
def _places() -> tuple[tuple[str, str], ...]:
    """Return every parameter: its node, or `/**`, and its name there."""
    # the envelope alone has groups of the controller
    nodes = [node for node in NODES if node.name != ENVELOPE]
    of_nodes = [(node.name, info.name) for node in nodes for info in describe(node.parameters_type())]
    shared = [
        (WILDCARD, name)
        for node in nodes
        for name in owned_names(node.name, [of for where, of in of_nodes if where == node.name])
    ]
    return (*((WILDCARD, f"{EVERY_NODE}.{info.name}") for info in describe(RunParameters)), *shared, *of_nodes)


def _alike(one: str, other: str) -> int:
    """Return how many words two dotted names have in common where one of them ends with the other; else 0."""
    shorter, longer = sorted((one.removeprefix(SYSTEM).split("."), other.removeprefix(SYSTEM).split(".")), key=len)
    return len(shorter) if longer[-len(shorter) :] == shorter else 0
