"""`heave new`: a scenario file of one's own, with a comment beside each value."""

from __future__ import annotations

import argparse
import math
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from heave_node.catalogue import FROM, KINDS
from heave_node.parameters import ParameterError

from heave_bringup.commands.command import add_model

if TYPE_CHECKING:
    from heave_node.scenario import Sections

    from heave_bringup.scenarios import Scenario

SUMMARY = "Write your own scenario file, with a unit and a comment beside each value."
EXAMPLES = (
    "heave new my_lift",
    "heave new my_lift --mass 6000 --volume 1.2 --depth 2000 --hs 2.2 --tp 9",
    "heave new my_lift --mass 40000 --density 3500 --cable wire_48mm_6x36 --depth 800",
    "heave new my_lift --like unit_1500 --cable wire_28mm_6x36 --length 1500",
)

STRENGTHS = {"cable": ("breaking_force", "safety_factor"), "unit": (), "winch": ("rated_pull",)}
"""Values of the model that another cable or winch does not take over, whether its entry states them or not."""


class Quantity(NamedTuple):
    """A figure of the lift that the command line takes: its `name` and `unit`, and its help in `words`."""

    name: str
    unit: str
    words: str


LIFT = {
    "mass": Quantity("mass", "kg", "mass of the load in air; needs --volume or --density"),
    "volume": Quantity("volume", "m^3", "displaced volume; added mass and drag area scale with it"),
    "density": Quantity("density", "kg/m^3", "mean density of the load, instead of --volume (solid steel: 7850)"),
    "hs": Quantity("Hs", "m", "significant wave height"),
    "tp": Quantity("Tp", "s", "peak period"),
    "length": Quantity("length", "m", "rope paid out"),
    "depth": Quantity(
        "depth", "m", "depth of the load before the rope stretches; rope length is depth plus height of the boom tip"
    ),
}
SEA = {"hs": "system.sea.significant_wave_height", "tp": "system.sea.peak_period"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("file", metavar="SCENARIO", help="name or file to write; my_lift writes my_lift.yaml")
    add_model(parser, "start from the values of this scenario")
    for kind in KINDS:
        words = "load (unit)" if kind == "unit" else kind
        parser.add_argument(f"--{kind}", metavar="NAME", help=f"a {words} of the catalogue (heave list {kind})")
    for name, of in LIFT.items():
        parser.add_argument(f"--{name}", metavar=of.unit.upper(), type=float, help=of.words)
    parser.add_argument("--title", metavar="TEXT", help="title of the lift in its reports")
    parser.add_argument("--force", action="store_true", help="overwrite an existing file")


def execute(options: argparse.Namespace) -> None:
    """Write the file that `options` name, and check it."""
    from cable_sim_node.vertical.axial_line import axial_line
    from heave_node.loads.strength import payload_words

    from heave_bringup.commands.models.loads import odd_load, short_at_rest
    from heave_bringup.output import warn, write_result
    from heave_bringup.pages.commented_scenario import commented_scenario
    from heave_bringup.scenarios import description_of, find_scenario, load_scenario, sections_for, write_scenario

    path = Path(options.file)
    path = path if path.suffix in (".yaml", ".yml") else path.with_name(f"{path.name}.yaml")
    if path.exists() and not options.force:
        raise ParameterError(f"{path}: exists already; --force overwrites it")
    model = find_scenario(options.like)
    known = load_scenario(options.like, needs_files=False)  # an error in it is reported of it, not of what follows
    sections = _with_lift(_changed(sections_for(model, path.parent), options), options, known)
    changed = _changes(options)
    origin = f"{model.stem}, {changed}" if changed else description_of(model).rstrip(".") or model.stem
    title = f"{path.stem}: made from {origin}"
    text = commented_scenario(sections, title=title, path=str(path))
    write_scenario(path, text, needs_files=False)
    how = f"run it: heave run {shlex.quote(str(path))}"
    scenario = load_scenario(str(path), needs_files=False)
    plant = scenario.parameters["cable_sim"]
    load = payload_words(plant.unit.mass, plant.unit.volume, plant.water_density)
    unit = f"load: {load}, displaces {plant.unit.volume:.3g} m^3; rope: {plant.length:g} m"
    stretch = axial_line(plant, scenario.parameters["wave_vessel"].boom_tip_height).static_stretch(plant.length)
    if options.depth is not None:
        unit += f"\nnote: depth {options.depth:g} m is before stretch; at rest the rope stretches by {stretch:.2g} m"
    if (options.mass, options.volume, options.density) != (None, None, None):
        shape = options.unit or model.stem
        unit += f"\nnote: added mass and drag area are scaled from the load of {shape}: check them"
    if known.wanted:
        unit += f"\nnote: the criteria (wanted) are those of {model.stem}: check them"
    warn([*odd_load(scenario), *short_at_rest(scenario)])
    words = f"{path}: {sum(map(len, sections.values()))} values, each with its meaning\n{unit}\n{how}"
    write_result(options, words, {"file": str(path.resolve()), "like": model.stem})


def _changes(options: argparse.Namespace) -> str:
    """Return in words what the user has named; "" where nothing."""
    parts = [f"{kind} {getattr(options, kind)}" for kind in KINDS if getattr(options, kind) is not None]
    values = ((name, of, getattr(options, name)) for name, of in LIFT.items())
    parts += [f"{of.name} {value:g} {of.unit}" for _, of, value in values if value is not None]
    return f"with {', '.join(parts)}" if parts else ""


def _changed(sections: Sections, options: argparse.Namespace) -> Sections:
    """Return sections in which what the user has named stands in the place of the model's own values."""
    from heave_node.catalogue import find
    from heave_node.scenario import WILDCARD

    shared = dict(sections.get(WILDCARD, {}))
    for kind in KINDS:
        name = getattr(options, kind)
        if name is not None:
            entry = find(kind, name, f"--{kind}")
            given = (FROM, *entry.values, *STRENGTHS[kind])
            replaced = [f"system.{kind}", *(f"system.{kind}.{value}" for value in given)]
            kept = {key: value for key, value in shared.items() if key not in replaced}
            has_more = any(key.startswith(f"system.{kind}.") for key in kept)
            shared = {f"system.{kind}.{FROM}" if has_more else f"system.{kind}": entry.name, **kept}
    ordered = dict(sorted(shared.items(), key=lambda item: item[0].startswith("system.")))  # in order otherwise
    first = {WILDCARD: ordered} if ordered else {}
    return {**first, **{name: values for name, values in sections.items() if name != WILDCARD}}


def _with_lift(sections: Sections, options: argparse.Namespace, model: Scenario) -> Sections:
    """Return `sections` with the lift that the user states: unit, sea, length and title, the rest from the `model`."""
    from heave_node.scenario import WILDCARD

    found: dict[str, object] = {name: getattr(options, short) for short, name in SEA.items()}
    found |= _unit(options, model) | {"system.length": _length(options, model)}
    found = {name: value for name, value in found.items() if value is not None}
    if not found and not options.title:
        return sections
    _refuse_hidden(found, sections, options.like)
    if (options.hs, options.tp) != (None, None) and model.parameters["wave_vessel"].boom_tip_source != "spectrum":
        raise ParameterError(f"--hs, --tp: {options.like} has no sea to change; --like another scenario")
    shared = dict(sections.get(WILDCARD, {}))
    if any(name.startswith("system.unit.") for name in found):
        shared = {name: value for name, value in shared.items() if not name.startswith("system.unit.attachment_")}
        if "system.unit" in shared:
            shared[f"system.unit.{FROM}"] = shared.pop("system.unit")
    head = {"title": options.title} if options.title else {}
    others = {name: values for name, values in sections.items() if name != WILDCARD}
    return {WILDCARD: {**head, **shared, **found}, **others}


def _unit(options: argparse.Namespace, model: Scenario) -> dict[str, object]:
    """Return the values of a unit of the stated mass and volume, of the shape of the one that the file begins with.

    Of one shape, added mass grows as the volume V, drag area as V^(2/3).
    """
    from heave_node.catalogue import find

    if (options.mass, options.volume, options.density) == (None, None, None):
        return {}
    _refuse_unknown_weight(options)
    unit = model.parameters["cable_sim"].unit
    own: Mapping[str, Any] = find("unit", options.unit, "--unit").values if options.unit else {}
    mass, volume = own.get("mass", unit.mass), own.get("volume", unit.volume)
    for name in ("mass", "volume", "density"):
        stated = getattr(options, name)
        if stated is not None and not 0.0 < stated < math.inf:
            raise ParameterError(f"--{name} {stated:g}: must be above 0")
    heavy = options.mass if options.mass is not None else mass
    new = heavy / options.density if options.density is not None else options.volume
    ratio, density = new / volume if volume > 0.0 else 1.0, model.parameters["cable_sim"].water_density
    if not density * new < heavy:
        raise ParameterError(f"--mass {heavy:g} --volume {new:.4g}: the load floats, displacing {density * new:.4g} kg")
    added, areas = own.get("added_mass", unit.added_mass), own.get("drag_area", unit.drag_area)
    return {
        "system.unit.mass": heavy,
        "system.unit.volume": float(f"{new:.6g}"),
        "system.unit.added_mass": [float(f"{value * ratio:.6g}") for value in added],
        "system.unit.drag_area": [float(f"{value * ratio ** (2.0 / 3.0):.6g}") for value in areas],
    }


def _refuse_unknown_weight(options: argparse.Namespace) -> None:
    """Refuse a mass whose weight in water would be a guess, and a volume stated twice."""
    if options.volume is not None and options.density is not None:
        raise ParameterError("--density: give either the --volume or the --density of the load")
    if options.volume is None and options.density is None:
        raise ParameterError(
            f"--mass {options.mass:g}: its weight in water is not known; add --volume (m^3 of water that it displaces) "
            "or --density (kg/m^3, its mean density; solid steel has 7850)"
        )


def _length(options: argparse.Namespace, model: Scenario) -> float | None:
    """Return the length of the cable that the user states, by itself or by the depth of the unit."""
    if options.depth is None:
        length: float | None = options.length
        return length
    if options.length is not None:
        raise ParameterError("--depth: give either the depth of the unit or the --length of the cable")
    return float(options.depth) + float(model.parameters["cable_sim"].boom_tip_height)


def _refuse_hidden(found: Mapping[str, object], sections: Sections, like: str) -> None:
    """Refuse a value that would not reach a node of `sections`, since that states its own."""
    from heave_node.scenario import WILDCARD
    from heave_node.system_parameters import own_name

    for section, values in sections.items():
        node = section.rpartition("/")[2]
        hidden = [name for name in found if section != WILDCARD and own_name(node, name) in values]
        if hidden:
            raise ParameterError(f"{hidden[0]}: {like} states another for {node}; --like another scenario")
