"""What commands on models say of the strength of a lift: lines for people, and a verdict."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from heave_node.catalogue import entries
from heave_node.loads.strength import ROPE, LoadCheck, Strength, load_checks, strengths
from heave_node.parameters import flatten

from heave_bringup.errors import VerdictError

if TYPE_CHECKING:
    from heave_bags.analyse.verdict import Verdict

    from heave_bringup.scenarios import Scenario


LIGHT = 0.02
"""A load that weighs less than this share of its rope in water is hardly meant [-]; the lightest of the catalogue on
its longest rope has some 0.1."""

LEAD = 11_340.0
"""Density of lead, above which the volume of a load is hardly meant [kg/m^3]."""


def strengths_in(scenario: Scenario) -> tuple[Strength, ...]:
    """Return what the parts of a `scenario` can carry, of those whose strength is stated."""
    return strengths(flatten(scenario.parameters["cable_sim"]), flatten(scenario.parameters["virtual_winch"]))


def short_at_rest(scenario: Scenario) -> list[str]:
    """Return in words which parts of a `scenario` carry its load in still water with less than their factor.

    Of the rope, the smallest of the catalogue that does is named.
    """
    words = []
    for check in _checks_at_rest(scenario):
        if check.is_failed:
            part = check.strength
            ropes = _ropes_for(scenario) if part.key == ROPE else []
            smallest = f" (smallest rope of the catalogue: --cable {ropes[0]})" if ropes else ""
            words.append(
                f"{part.part} {check.factor:.2f} in still water (required at least {part.required:.4g}): "
                f"{part.kind} {1e-3 * part.capacity:.0f} kN, static load {1e-3 * check.load:.0f} kN. "
                f"Use {1e-3 * part.required * check.load:.0f} kN or more{smallest}, or a lighter load"
            )
    return words


def odd_load(scenario: Scenario) -> list[str]:
    """Return in words that the load of a `scenario` is next to nothing beside its rope, or denser than lead: its mass
    or volume may be in another unit.
    """
    plant = scenario.parameters["cable_sim"]
    unit, words = plant.unit, []
    load = unit.weight_in_fluid(plant.water_density, plant.gravity)
    rope = plant.length * plant.cable.weight_in_fluid(plant.water_density, plant.gravity)
    if load < LIGHT * rope:
        share = 100.0 * load / rope
        words.append(f"the load of {unit.mass:g} kg weighs {share:.1g} % of the rope in water: masses are in kg")
    if unit.mass > LEAD * unit.volume > 0.0:
        words.append(f"the load of {unit.mass:g} kg in {unit.volume:g} m^3 is denser than lead: check mass and volume")
    return words


def _checks_at_rest(scenario: Scenario) -> tuple[LoadCheck, ...]:
    from cable_sim_node.vertical.axial_line import axial_line

    plant, height = scenario.parameters["cable_sim"], scenario.parameters["wave_vessel"].boom_tip_height
    top = axial_line(plant, height).static_top_tension(plant.length)
    return load_checks(
        strengths_in(scenario), top=top, unit=plant.unit.weight_in_fluid(plant.water_density, plant.gravity)
    )


def _ropes_for(scenario: Scenario) -> list[str]:
    """Return the ropes of the catalogue that carry the load of a `scenario` in still water, the weakest first."""
    plant = scenario.parameters["cable_sim"]
    found = []
    for name, entry in entries("cable").items():
        rope = replace(plant, cable=replace(plant.cable, **entry.values))
        checks = _checks_at_rest(replace(scenario, parameters={**scenario.parameters, "cable_sim": rope}))
        if any(check.strength.key == ROPE and not check.is_failed for check in checks):
            found.append((entry.breaking_force, name))
    return [name for _, name in sorted(found)]


def load_lines(verdict: Verdict) -> list[str]:
    """Return the lines of a `verdict` on loads below a table, and what it could not judge."""
    return ["", *(verdict.lines() if verdict.loads else verdict.remarks)]


def refuse_failed(verdict: Verdict) -> None:
    """Raise VerdictError for a `verdict` that is FAILED."""
    if not verdict.is_good:
        raise VerdictError(verdict.failures)
