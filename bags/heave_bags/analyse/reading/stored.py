"""What a bag carries of its scenario: title, criteria and the parameters of its nodes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import Any

from heave_node.criteria import WANTED, Criterion, parse_criterion
from heave_node.loads.strength import strengths
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY
from heave_node.numerics.hydrostatics import displaced_area, weight_in_fluid
from heave_node.parameters import Given, ParameterError
from heave_node.scenario import CHANGED, WILDCARD, Sections, parse_sections, values_of_node

from heave_bags.analyse import kpi_set
from heave_bags.mcap.reader import Bag
from heave_bags.record.provenance import PARAMETERS_ATTACHMENT, SCENARIO_ATTACHMENT
from heave_bags.signals import RunSignals

NodeParameters = Mapping[str, Mapping[str, Any]]
"""Parameters of nodes: node -> dotted name -> value. Those of all nodes are under ALL_NODES."""
ALL_NODES = "**"
LONGEST_TEXT = 1000
"""Letters of a title or description that a bag may bring."""
LONGEST_HEAD = 16_000
"""Bytes of a stored scenario in which its comment is looked for."""


def stored_scenario(bag: Bag) -> tuple[tuple[Criterion, ...], dict[str, dict[str, Any]]]:
    """Return what was wanted of the run of a `bag`, and its nodes' parameters by node and dotted name; what it has.

    A killed recorder had no time to add what the nodes reported; the scenario is there from the start.
    """
    attachments = bag.attachments
    wanted: tuple[Criterion, ...] = ()
    nodes: dict[str, dict[str, Any]] = {}
    for name in (SCENARIO_ATTACHMENT, PARAMETERS_ATTACHMENT):
        try:
            content = attachments.get(name, b"")
            sections = parse_sections(content, name)
            if name == SCENARIO_ATTACHMENT:
                wanted = _wanted(sections, name)
        except (ParameterError, ValueError):
            continue
        for node in ("cable_sim", "wave_vessel", "virtual_winch", "winch_controller"):
            nodes.setdefault(node, {}).update(values_of_node(sections, f"/{node}"))
    return wanted, nodes


def stored_title(bag: Bag) -> tuple[str, str]:
    """Return title and description of the lift, as the scenario in the `bag` states them: its first line is one."""
    content = bag.attachments.get(SCENARIO_ATTACHMENT, b"")
    first = content[: 4 * LONGEST_TEXT].decode("utf-8", errors="replace").partition("\n")[0]
    try:
        shared = parse_sections(content, SCENARIO_ATTACHMENT).get(WILDCARD, {})
    except (ParameterError, ValueError):
        shared = {}
    title, words = (str(shared.get(name) or "").strip()[:LONGEST_TEXT] for name in ("title", "description"))
    return title, words or (first.lstrip("# ").strip()[:LONGEST_TEXT] if first.startswith("#") else "")


def stored_changes(bag: Bag) -> dict[str, str]:
    """Return, under CHANGED, the places of the parameters that were changed for the run in the `bag`; empty: none."""
    content = bag.attachments.get(SCENARIO_ATTACHMENT, b"")[:LONGEST_HEAD].decode("utf-8", errors="replace")
    head = itertools.takewhile(lambda line: line.startswith("#"), content.split("\n"))
    found = [line.removeprefix(f"# {CHANGED}: ") for line in head if line.startswith(f"# {CHANGED}: ")]
    return {CHANGED: found[0]} if found else {}


def _wanted(sections: Sections, name: str) -> tuple[Criterion, ...]:
    """Return the criteria of a stored scenario, for figures that are still known."""
    given = (Given(value, key, name) for key, value in sections.get(WILDCARD, {}).items() if key.startswith(WANTED))
    criteria = [parse_criterion(one) for one in given]
    return tuple(criterion for criterion in criteria if criterion.kpi in kpi_set.DEFINITION_OF)


def as_number(value: Any, default: float = math.nan) -> float:
    """Return a `value` of a bag as a number; the `default` where it is none."""
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return default


def number(parameters: Mapping[str, Any], name: str, default: float) -> float:
    """Return the parameter `name` of a node's `parameters` as a number; the `default` where it is none."""
    return as_number(parameters.get(name), default)


def cable_weight(plant: Mapping[str, Any]) -> float:
    """Return weight minus buoyancy of the cable that is paid out, by the `plant`'s parameters [N/m]; 0: not known."""
    diameter = number(plant, "cable.diameter", math.nan)
    displaced = displaced_area(diameter, number(plant, "cable.displaced_diameter", 0.0))
    weight = weight_in_fluid(
        number(plant, "cable.mass_per_length", math.nan),
        displaced,
        number(plant, "water_density", SEAWATER_DENSITY),
        number(plant, "gravity", STANDARD_GRAVITY),
    )
    return weight if math.isfinite(weight) else 0.0


def fill_parameters(signals: RunSignals, nodes: NodeParameters) -> None:
    """Fill in the `signals` of a run what the parameters of its `nodes` say: limits, strengths, driving frequency."""
    winch, vessel = nodes.get("virtual_winch", {}), nodes.get("wave_vessel", {})
    signals.speed_limit = number(winch, "speed_limit", math.inf)
    signals.acceleration_limit = number(winch, "acceleration_limit", math.inf)
    signals.power_limit = number(winch, "power_limit", math.inf) or math.inf  # 0 means no limit
    # a ship has no plant: its controller knows the same cable and unit
    signals.strengths = strengths({**nodes.get("winch_controller", {}), **nodes.get("cable_sim", {})}, winch)
    if vessel.get("boom_tip_source") == "regular":
        period = number(vessel, "period", math.nan)
        signals.driving_omega = 2.0 * math.pi / period if period > 0.0 else math.nan
