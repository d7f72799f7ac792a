"""Every command line in the documents and in the help is one that the command takes."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from heave_bringup.commands.command import name_of
from heave_bringup.parser import all_commands, make_parser
from heave_bringup.scenarios import load_scenario, shipped_scenarios

REPOSITORY = Path(__file__).parents[2]
DOCUMENTS = sorted([*REPOSITORY.glob("*.md"), *REPOSITORY.glob("*/README.md"), *REPOSITORY.glob("docs/**/*.md")])
PLACEHOLDER = re.compile(r"\b(SCENARIO|BAG|CAMPAIGN|FILE|COMMAND|NODE|PARAM|DIR|NAME)\b|\.\.\.|--help")


def command_lines(text: str) -> list[str]:
    """Return what stands as a `heave` command in a block or between backquotes, a comment after it taken off."""
    between = re.findall(r"`(heave [^`]*)`", text.replace("\n", " "))
    in_blocks = [line for block in re.findall(r"```sh\n(.*?)```", text, re.S) for line in block.splitlines()]
    lines = [*between, *(line for line in in_blocks if line.startswith("heave "))]
    return [line for line in lines if not PLACEHOLDER.search(line) and len(line.split()) > 1]


TEXTS = [path.read_text(encoding="utf-8") for path in DOCUMENTS]
DOCUMENTED = sorted({line for text in TEXTS for line in command_lines(text)})
MADE = {f"{name}.yaml" for text in TEXTS for name in re.findall(r"heave new (\w+)", text)} | {
    name for text in TEXTS for name in re.findall(r"(?:--scenario (?=\w+\.yaml)|--output (?=\w+\.parquet))(\S+)", text)
}
CASES = [found for text in TEXTS for found in re.findall(r"--case (?:\S*/)?(\w+)\.parquet:(\d+)", text)]
MADE |= {f"{table}_case_{case}.yaml" for table, case in CASES}
"""Scenarios and tables of cases that a page makes before it runs them; `tests/test_guide.py` does that."""


@pytest.mark.parametrize(
    "line", [*(example for command in all_commands() for example in command.EXAMPLES), *DOCUMENTED]
)
def test_a_documented_command_line_is_understood(line: str) -> None:
    arguments = shlex.split(line.partition(" > ")[0], comments=True)[1:]
    if len(arguments) == 1 and arguments[0] != "list":
        assert arguments[0] in {name_of(command) for command in all_commands()}  # the command is named, not given
        return
    options = make_parser().parse_args(arguments)
    if options.command in ("run", "static", "design", "identify"):
        name = options.scenario if options.command != "identify" else options.source
        if name.partition(":")[0] in MADE:
            return
        load_scenario(name, settings=options.set, needs_files=False)  # a page makes its files as it goes


def test_there_are_documented_command_lines() -> None:
    assert len(DOCUMENTED) > 10


@pytest.mark.parametrize("name", sorted(shipped_scenarios()))
def test_a_setting_that_a_scenario_recommends_is_one_that_it_takes(name: str) -> None:
    comments = [line for line in shipped_scenarios()[name].read_text().splitlines() if line.startswith("#")]
    settings = re.findall(r"--set (\S+)", " ".join(comments))
    load_scenario(name, settings=settings)
