"""`heave new`: a scenario file of one's own, with a comment beside each value."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from heave_node.catalogue import FROM, KINDS

from heave_bringup.commands.command import Command, add_model
from heave_bringup.errors import CommandError

if TYPE_CHECKING:
    from heave_node.scenario import Sections

STRENGTHS = {"cable": ("breaking_force", "safety_factor"), "unit": (), "winch": ("rated_pull",)}
"""What another cable or winch does not take over from the model's, whether its entry states it or not."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("file", metavar="SCENARIO", help="name or file to write: my_lift gives my_lift.yaml")
    add_model(parser, "begin with the values of this one")
    for kind in KINDS:
        parser.add_argument(f"--{kind}", metavar="NAME", help=f"a {kind} of the catalogue (heave catalogue {kind})")
    parser.add_argument("--length", metavar="M", type=float, help="deployed length of the cable")
    parser.add_argument("--force", action="store_true", help="write over a file that is there")


def execute(options: argparse.Namespace) -> None:
    """Write the file that `options` name, and check it."""
    from heave_bringup.output import write_result
    from heave_bringup.pages.commented_scenario import commented_scenario
    from heave_bringup.scenarios import description_of, find_scenario, load_scenario, sections_for, write_scenario

    path = Path(options.file)
    path = path if path.suffix in (".yaml", ".yml") else path.with_name(f"{path.name}.yaml")
    if path.exists() and not options.force:
        raise CommandError(f"{path}: is there already; --force writes over it")
    model = find_scenario(options.like)
    load_scenario(options.like, needs_files=False)  # what is wrong with it is said of it, not of what is made of it
    sections = _changed(sections_for(model, path.parent), options)
    title = f"{path.stem}: made from {description_of(model).rstrip('.') or model.stem}"
    text = commented_scenario(sections, title=title, path=str(path))
    write_scenario(path, text, needs_files=False)
    how = f"run it: heave run {shlex.quote(str(path))}"
    words = f"{path}: {sum(map(len, sections.values()))} values, each with its meaning\n{how}"
    write_result(options, words, {"file": str(path.resolve()), "like": model.stem})


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
    if options.length is not None:
        shared["system.length"] = options.length
    ordered = dict(
        sorted(shared.items(), key=lambda item: item[0].startswith("system."))
    )  # a sort keeps the order else
    first = {WILDCARD: ordered} if ordered else {}
    return {**first, **{name: values for name, values in sections.items() if name != WILDCARD}}


COMMAND = Command(
    name="new",
    summary="Write a scenario file of your own, with unit and meaning beside each value.",
    examples=(
        "heave new my_lift",
        "heave new my_lift --like unit_1500 --cable wire_28mm_6x36 --length 1500",
    ),
    add_arguments=add_arguments,
    execute=execute,
)
