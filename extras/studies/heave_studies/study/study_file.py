"""Studies as a user states them: in a file, or on the command line.

A study is a YAML file:

    title: My winch in three seas     # optional
    scenario: b3_deep_900             # a shipped one, or a file beside this one
    duration: 600                     # optional; the scenario's own otherwise
    seeds: [1, 2, 3]                  # or a number of seeds, counted from 1
    set: {winch_controller.law: mpc}  # for every case
    wanted: {unit_sigma_m: "<= 0.01"} # criteria, as in a scenario
    screening: true                   # cases away from the winch's limits under a fixed law, not in the full loop
    adviser: false                    # cases run without it, in less time; heave run --replace winch_adviser=none
    vary:                             # every combination of what stands in the list ...
      - {system.sea.peak_period: [8, 10, 12]}
      - {virtual_winch.speed_limit: [1, 2], virtual_winch.power_limit: [1e5, 2e5]}      # ... these two move together
      - {"virtual_winch.command_delay, winch_controller.winch.command_delay": [0.2, 0.3]}   # one value for both
      - {base: [b2_calm_300, b3_deep_900]}        # the scenario itself
    draw:                             # random cases, seeded
      count: 64
      seed: 1
      method: latin                   # random (default), latin (hypercube), sobol, or saltelli (for Sobol' indices)
      nominal: true                   # before them the scenario itself, to compare with
      uniform: {cable_sim.cable.axial_stiffness: [1.1e7, 2.0e7]}   # the plant alone
      log_uniform: {cable_sim.unit.mass: [1.0e4, 1.0e5]}
      choose: {winch_controller.law: [off, lqg, mpc]}
      # a place that ends in [] takes the value as the one entry of a list: wave_vessel.mru.faults.start[]: [60, 200]
    until: {figure: unit_sigma_m, width: 10 %, most: 64}  # more seeds, until the mean's 90 % interval is so narrow
    search: {figure: silent_minute, runs: 480, at_most: 1.05}      # from these draws on, for the worst case
    phases: [{name: landing, depth: [1490, 1500], speed: 0.2}]     # of a lift, see `heave_studies.study.phases`
    ask: {answer: limits, within: 0.5}            # what is made of the cases, see `heave_studies.answers`

`vary` may also be a mapping: each of its parameters is then varied by itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

from heave_bringup.run.criteria import parse_requirement
from heave_bringup.scenarios import find_scenario, shipped_scenarios
from heave_bringup.settings import make_setting, plain_settings, yaml_value
from heave_node.files.bounded_yaml import YamlError, parse_yaml
from heave_node.files.file_kinds import PARAMETERS_KEY, refuse_other_kind
from heave_node.files.given_files import as_mapping, find_stated, read_stated, refuse_keys, scenario_of
from heave_node.parameters import ParameterError

from heave_studies.study.enough import KEYS as UNTIL_KEYS
from heave_studies.study.enough import read_until
from heave_studies.study.phases import read_phases
from heave_studies.study.plan import BASE, Link, Search, Study
from heave_studies.study.sampling import Draws

FOLDER = Path(str(resources.files("heave_studies"))) / "studies"
"""Of the studies that come with the suite."""
VARY, ASK = "--vary", "--ask"
KEYS = {
    "title",
    "scenario",
    "duration",
    "seeds",
    "set",
    "wanted",
    "adviser",
    "screening",
    "vary",
    "phases",
    "draw",
    "search",
    "until",
    "ask",
}
_DRAW_KEYS = {"count", "seed", "method", "nominal", "uniform", "log_uniform", "choose"}
_SEARCH_KEYS = {"figure", "runs", "at_most"}


def find_study(name: str) -> Path:
    """Return the file of the shipped study `name`, or the file `name`; raise ParameterError where neither is."""
    if name in shipped_scenarios():
        refuse_other_kind({PARAMETERS_KEY: {}}, KEYS, name)
    return find_stated(name, FOLDER, "study")


def read_study(path: Path) -> Study:
    """Read and check the study file `path`; raise ParameterError, in one line, for what is wrong with it."""
    _, content = read_stated(path, KEYS, ("scenario",))

    def part(name: str, known: Iterable[str] | None = None) -> Mapping[str, Any]:
        found = as_mapping(content.get(name) or {}, f"{path}: {name}")
        if known is not None:
            refuse_keys(found, known, f"{path}: {name}")
        return found

    draw, search, until = part("draw", _DRAW_KEYS), part("search", _SEARCH_KEYS), part("until", UNTIL_KEYS)
    try:
        study = Study(
            path=path,
            scenario=stated_scenario(path, content),
            title=str(content.get("title", "")),
            duration=float(content["duration"]) if "duration" in content else None,
            seeds=_seeds(content.get("seeds", 1)),
            common=dict(part("set")),
            wanted=dict(part("wanted")),
            vary=_links(content.get("vary") or {}),
            phases=read_phases(content["phases"], f"{path}: phase") if "phases" in content else (),
            draws=_draws(draw, f"{path}: draw") if draw else None,
            has_nominal=bool(draw.get("nominal", False)),
            has_adviser=bool(content.get("adviser", True)),
            has_screening=bool(content.get("screening", False)),
            search=_search(search) if search else None,
            refinement=read_until(until, f"{path}: until") if until else None,
            ask=dict(part("ask")),
        )
        if study.search is not None and (study.draws is None or study.vary):
            raise ValueError("search: needs a draw, whose space it searches, and no vary")
        if study.search is not None and study.refinement is not None:
            raise ValueError("until: is not for a search")
    except (TypeError, ValueError) as error:
        raise error if isinstance(error, ParameterError) else ParameterError(f"{path}: {error}") from error
    return study


def stated_scenario(path: Path, content: Mapping[str, Any]) -> str:
    """Return the scenario that the `content` of the file at `path` names; raise ParameterError where there is none."""
    name = scenario_of(path, content)
    try:
        find_scenario(name)
    except ParameterError as error:
        raise ParameterError(f"{path}: scenario: {error}") from error
    return name


def _links(vary: Any) -> tuple[Link, ...]:
    """Return the groups of parameters that move together: each of a mapping by itself, or the mappings of a list."""
    groups = [{name: values} for name, values in vary.items()] if isinstance(vary, Mapping) else vary
    if not isinstance(groups, list) or not all(isinstance(group, Mapping) for group in groups):
        raise ValueError("vary: must be a mapping of parameters to lists of values, or a list of such mappings")
    links = []
    for group in groups:
        link = {name: _values(name, values) for name, values in group.items()}
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


def _draws(draw: Mapping[str, Any], where: str) -> Draws:
    def bounds(key: str) -> dict[str, tuple[float, float]]:
        found = {}
        for name, given in as_mapping(draw.get(key) or {}, f"{where}.{key}").items():
            if not isinstance(given, list) or len(given) != 2:
                raise ValueError(f"draw.{key}: {name} = {given!r}: must be [smallest, largest]")
            found[name] = (float(given[0]), float(given[1]))
        return found

    chosen = as_mapping(draw.get("choose") or {}, f"{where}.choose")
    return Draws(
        count=int(draw.get("count", 1)),
        seed=int(draw.get("seed", 1)),
        method=str(draw.get("method", "random")),
        uniform=bounds("uniform"),
        log_uniform=bounds("log_uniform"),
        choose={name: _values(name, values) for name, values in chosen.items()},
    )


def _search(given: Mapping[str, Any]) -> Search:
    if "figure" not in given:
        raise ValueError("search: figure is missing: which figure is to become large")
    return Search(**{"figure": str(given["figure"]), **{k: t(given[k]) for k, t in _NUMBERS if k in given}})


_NUMBERS: Sequence[tuple[str, type]] = (("runs", int), ("at_most", float))


def _seeds(value: Any) -> tuple[int, ...]:
    if isinstance(value, bool) or not isinstance(value, int | list):
        raise ValueError(f"seeds = {value!r}: must be a number of seeds or a list of seeds")
    seeds = tuple(range(1, value + 1)) if isinstance(value, int) else tuple(int(seed) for seed in value)
    if not seeds:
        raise ValueError("seeds must be a number of at least 1 or a list of seeds")
    return seeds


def study_of(scenario: str) -> Study:
    """Return the study of a `scenario`, a shipped name or a file, that the options of the command line make."""
    return Study(path=Path(VARY), scenario=scenario, title=Path(scenario).stem)


def with_options(
    study: Study,
    *,
    settings: Sequence[str] = (),
    vary: Sequence[str] = (),
    require: Sequence[str] = (),
    ask: Sequence[str] = (),
) -> Study:
    """Return a study with what the command line changes.

    Parameters
    ----------
    study : from its file
    settings : PLACE=VALUE each, in every case
    vary : PLACE=VALUE,VALUE,... each, the values in YAML; one of a place that the study varies takes its place
    require : criteria, KPI<VALUE each
    ask : KEY=VALUE each, for the answer

    Raises ParameterError for another form, a place that is none, and the same place twice.
    """
    links: dict[str, Link] = {}
    for text in vary:
        place, values = _varied(text)
        if place in links:
            raise ParameterError(f"{VARY} {place}: stands twice; give all its values once, separated by commas")
        links[place] = {place: values}
    kept = [links.pop(next(iter(link))) if len(link) == 1 and next(iter(link)) in links else link
            for link in study.vary]  # fmt: skip
    return replace(
        study,
        common={**study.common, **plain_settings(settings)},
        vary=(*kept, *links.values()),
        wanted={**study.wanted, **{one.kpi: one.text for one in map(parse_requirement, require)}},
        ask={**study.ask, **asked_values(ask)},
    )


def asked_values(texts: Sequence[str]) -> dict[str, object]:
    """Return what the `texts` of options ask, KEY=VALUE each; raise ParameterError for another form."""
    asked = {}
    for text in texts:
        key, separator, value = text.partition("=")
        if not separator:
            raise ParameterError(f"{ASK} {text}: must be KEY=VALUE, such as within=0.5")
        asked[key] = yaml_value(value, f"{ASK} {text}")
    return asked


def _varied(text: str) -> tuple[str, tuple[object, ...]]:
    place, separator, values = text.partition("=")
    source = f"{VARY} {text}"
    if not separator or not values.strip():
        raise ParameterError(f"{source}: must be NODE.PARAM=VALUE,VALUE,... such as winch_controller.law=off,lqg,mpc")
    try:
        found = parse_yaml(f"[{values}]", only_true_and_false=True)
    except YamlError as error:
        raise ParameterError(f"{source}: {values!r} is not a list of YAML values: {error}") from error
    if place != BASE:
        make_setting(place, found[0], source)
    return place, tuple(found)
