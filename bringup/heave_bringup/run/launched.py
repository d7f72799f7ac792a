"""What the launch file of the loop does that is not launch's: read its arguments, prepare the run's folder."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path

from heave_node.files.bounded_yaml import YamlError, parse_yaml
from heave_node.parameters import ParameterError
from heave_node.scenario import WILDCARD, read_sections

from heave_bringup.nodes import ADVISER, nodes_to_start
from heave_bringup.replacements import EXTERNAL, LOCKSTEP, NONE, Replacements, external_settings, parse_replacements
from heave_bringup.run.run import RunFolder, new_run_folder, store_scenario
from heave_bringup.scenarios import load_scenario
from heave_bringup.settings import Setting

RESPAWNED = ("wave_vessel", ADVISER)
"""The sensors' node and the adviser: while they are away, a run in real time goes on."""

ARGUMENTS = {
    "scenario": ("b2_calm_300", "Shipped scenario or parameter file."),
    "folder": ("", "Folder for the bag; empty: runs/SCENARIO-NNN."),
    "pacing": ("", "lockstep or realtime; empty: as in the scenario."),
    "duration": ("", "Simulated seconds; empty: as in the scenario."),
    "seed": ("", "Seed of all random numbers; empty: as in the scenario."),
    "set": ("", "Changes of parameters, NODE.PARAM=VALUE, separated by spaces."),
    "replace": ("", "Nodes to replace: NODE=external[:CLOCK], NODE=lockstep, NODE=none, separated by spaces."),
    "params_file": ("", "Parameter file that goes before the scenario; empty: none."),
    "autostart": ("", "false: a lifecycle manager configures and activates the nodes; empty: as in the scenario."),
    "log_level": ("info", "debug, info, warn, error or fatal."),
    "composed": ("false", "true: all nodes in one process."),
    "respawn": ("false", f"true: start {' and '.join(RESPAWNED)} again when they end; real time only."),
    "namespace": ("", "Put the nodes and topics of the run, its clock too, under this name."),
}
"""Default and meaning of each argument."""


def settings_of(arguments: Mapping[str, str]) -> list[Setting | str]:
    """Return the changes of the scenario that the `arguments` of a launch ask for, by name; empty ones ask for none.

    Raises ParameterError for a value that cannot be read.
    """
    found: list[Setting | str] = _settings_in(arguments.get("params_file", ""))
    for name in ("pacing", "duration", "seed", "autostart"):
        text = arguments.get(name, "")
        if text:
            found.append(Setting(WILDCARD, name, _value(f"{name}:={text}", text), f"{name}:={text}"))
    found += external_settings(replacements_of(arguments).external, f"replace:={arguments.get('replace')}")
    try:
        found += shlex.split(arguments.get("set", ""))
    except ValueError as error:
        raise ParameterError(f"set:={arguments['set']}: {error}") from None
    return found


def replacements_of(arguments: Mapping[str, str]) -> Replacements:
    """Return what takes the places of nodes, by the `arguments` of a launch; raise ParameterError for what cannot."""
    return parse_replacements(arguments.get("replace", "").split(), "replace:=", (EXTERNAL, LOCKSTEP, NONE))


def _settings_in(file: str) -> list[Setting | str]:
    """Return what a parameter `file` changes; "" for none. Its sections are written as those of a scenario."""
    if not file:
        return []
    sections = read_sections(Path(file))
    return [
        Setting(section.rpartition("/")[2] if section != WILDCARD else section, name, value, f"{file}: {section}")
        for section, values in sections.items()
        for name, value in values.items()
    ]


def _value(source: str, text: str) -> object:
    try:
        return parse_yaml(text)
    except YamlError as error:
        raise ParameterError(f"{source}: {error}") from None


def prepare(arguments: Mapping[str, str]) -> tuple[RunFolder, list[str]]:
    """Check the scenario, write the run's parameter file into its folder, and return that and the nodes to start, by
    the `arguments` of the launch.

    Raises ParameterError or CommandError, in one line, for whatever is wrong.
    """
    replaced = replacements_of(arguments)
    scenario = replaced.apply(load_scenario(arguments["scenario"], settings=settings_of(arguments)))
    if arguments.get("respawn") == "true" and scenario.run.is_lockstep:
        raise ParameterError("respawn:=true needs pacing:=realtime: a run in lockstep waits for each of its nodes")
    folder = new_run_folder(scenario.name, Path(arguments["folder"]) if arguments.get("folder") else None)
    store_scenario(scenario, folder, replaced.entries)
    return folder, nodes_to_start(scenario.run, replaced.lockstep)
