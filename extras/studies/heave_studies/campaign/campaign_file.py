"""Campaigns as a user states them: in a file, or on the command line.

A campaign file is YAML:

    scenario: b9_model_error
    duration: 600                     # optional; the scenario's own otherwise
    seeds: [1, 2, 3]                  # or a number of seeds, counted from 1
    set: {winch_controller.law: mpc}  # for every case
    wanted: {unit_sigma_m: "<= 0.01"} # criteria, as in a scenario
    vary:                             # every combination of what stands in the list ...
      - {system.sea.peak_period: [8, 10, 12]}
      - {virtual_winch.speed_limit: [1, 2], virtual_winch.power_limit: [1e5, 2e5]}      # ... these two move together
      - {"virtual_winch.command_delay, winch_controller.winch.command_delay": [0.2, 0.3]}   # one value for both
    draw:                             # random cases, seeded
      count: 64
      seed: 1
      method: latin                   # random (default), latin (hypercube) or sobol
      nominal: true                   # before them the scenario itself, to compare with
      uniform: {cable_sim.cable.axial_stiffness: [1.1e7, 2.0e7]}   # the plant alone
      log_uniform: {cable_sim.unit.mass: [1.0e4, 1.0e5]}
      choose: {winch_controller.law: [off, lqg, mpc]}
      # a place that ends in [] takes the value as the one entry of a list: wave_vessel.mru.faults.start[]: [60, 200]

`vary` may also be a mapping: each of its parameters is then varied by itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

from heave_bringup.scenarios import shipped_scenarios
from heave_bringup.settings import make_setting, plain_settings
from heave_node.files.bounded_yaml import YamlError, parse_yaml
from heave_node.files.file_kinds import PARAMETERS_KEY, refuse_other_kind
from heave_node.files.given_files import find_stated, read_stated, refuse_keys
from heave_node.parameters import ParameterError

from heave_studies.campaign.plan import Campaign, Link
from heave_studies.campaign.sampling import Draws

VARY = "--vary"
"""Option that varies a parameter without a file."""
_KEYS = {"scenario", "duration", "seeds", "set", "wanted", "vary", "draw"}
_DRAW_KEYS = {"count", "seed", "method", "nominal", "uniform", "log_uniform", "choose"}


def find_campaign(name: str) -> Path:
    """Return the file of the shipped campaign `name`, or the file `name`; raise ParameterError where neither is."""
    if name in shipped_scenarios():
        refuse_other_kind({PARAMETERS_KEY: {}}, _KEYS, name)
    return find_stated(name, Path(str(resources.files("heave_studies"))) / "campaigns", "campaign")


def read_campaign(path: Path) -> Campaign:
    """Read and check the campaign file `path`; raise ParameterError, in one line, for what is wrong with it."""
    _, content = read_stated(path, _KEYS, ("scenario",))
    draw = content.get("draw") or {}
    try:
        refuse_keys(_mapping(draw, "draw"), _DRAW_KEYS, f"{path}: draw")
        return Campaign(
            path=path,
            scenario=str(content["scenario"]),
            duration=float(content["duration"]) if "duration" in content else None,
            seeds=_seeds(content.get("seeds", 1)),
            common=dict(_mapping(content.get("set") or {}, "set")),
            wanted=dict(_mapping(content.get("wanted") or {}, "wanted")),
            vary=_links(content.get("vary") or {}),
            draws=_draws(draw) if draw else None,
            has_nominal=bool(draw.get("nominal", False)),
        )
    except (TypeError, ValueError) as error:
        raise error if isinstance(error, ParameterError) else ParameterError(f"{path}: {error}") from error


def _links(vary: Any) -> tuple[Link, ...]:
    """Return the groups of parameters that move together: each of a mapping by itself, or the mappings of a list."""
    groups = [{name: values} for name, values in vary.items()] if isinstance(vary, Mapping) else vary
    if not isinstance(groups, list):
        raise ValueError("vary: must be a mapping of parameters to lists of values, or a list of such mappings")
    links = []
    for group in groups:
        link = {name: _values(name, values) for name, values in _mapping(group, "vary").items()}
        counts = {name: len(values) for name, values in link.items()}
        if len(set(counts.values())) > 1:
            numbers = ", ".join(f"{name} {count}" for name, count in counts.items())
            raise ValueError(f"vary: parameters that move together need equally many values: {numbers}")
        links.append(link)
    return tuple(links)


def _values(name: str, values: Any) -> tuple[object, ...]:
    if not isinstance(values, list) or not values:
        raise ValueError(f"vary: {name} = {values!r}: must be a list of at least one value")
    return tuple(values)


def _draws(draw: Mapping[str, Any]) -> Draws:
    return Draws(
        count=int(draw.get("count", 1)),
        seed=int(draw.get("seed", 1)),
        method=str(draw.get("method", "random")),
        uniform=_bounds(draw, "uniform"),
        log_uniform=_bounds(draw, "log_uniform"),
        choose={
            name: _values(name, values) for name, values in _mapping(draw.get("choose") or {}, "draw.choose").items()
        },
    )


def _bounds(draw: Mapping[str, Any], key: str) -> dict[str, tuple[float, float]]:
    bounds = {}
    for name, given in _mapping(draw.get(key) or {}, f"draw.{key}").items():
        if not isinstance(given, list) or len(given) != 2:
            raise ValueError(f"draw.{key}: {name} = {given!r}: must be [smallest, largest]")
        bounds[name] = (float(given[0]), float(given[1]))
    return bounds


def _mapping(value: Any, name: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise ValueError(f"{name}: must be a mapping, not {value!r}")
    return value


def _seeds(value: Any) -> tuple[int, ...]:
    if isinstance(value, bool) or not isinstance(value, int | list):
        raise ValueError(f"seeds = {value!r}: must be a number of seeds or a list of seeds")
    seeds = tuple(range(1, value + 1)) if isinstance(value, int) else tuple(int(seed) for seed in value)
    if not seeds:
        raise ValueError("seeds must be a number of at least 1 or a list of seeds")
    return seeds


def campaign_of(scenario: str, vary: Sequence[str]) -> Campaign:
    """Return the campaign of every combination of the values in `vary` in a `scenario`.

    Parameters
    ----------
    scenario : shipped name or file
    vary : texts PLACE=VALUE,VALUE,...; the values in YAML, as `--set` takes them

    Raises ParameterError for another form, a place that is none, and the same place twice.
    """
    links = [_link(text) for text in vary]
    places = [place for link in links for place in link]
    for place in places:
        if places.count(place) > 1:
            raise ParameterError(f"{VARY} {place}: stands twice; give all its values once, separated by commas")
    return Campaign(path=Path(VARY), scenario=scenario, vary=tuple(links))


def _link(text: str) -> Link:
    place, separator, values = text.partition("=")
    source = f"{VARY} {text}"
    if not separator or not values.strip():
        raise ParameterError(f"{source}: must be NODE.PARAM=VALUE,VALUE,... such as winch_controller.law=off,lqg,mpc")
    try:
        found = parse_yaml(f"[{values}]", only_true_and_false=True)
    except YamlError as error:
        raise ParameterError(f"{source}: {values!r} is not a list of YAML values: {error}") from error
    make_setting(place, found[0], source)
    return {place: tuple(found)}


def with_settings(campaign: Campaign, settings: Iterable[str]) -> Campaign:
    """Return the `campaign` with `settings` of the command line, PLACE=VALUE each, in every case."""
    return replace(campaign, common={**campaign.common, **plain_settings(settings)})
