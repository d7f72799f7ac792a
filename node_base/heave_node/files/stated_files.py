"""Files in which a user states work: campaigns, procedures, plans of lifts. Mappings of YAML, some of them shipped."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from heave_node.files.bounded_yaml import parse_yaml
from heave_node.files.file_kinds import refuse_other_kind
from heave_node.files.given_files import read_given
from heave_node.parameters import ParameterError


def shipped_files(folder: Path) -> dict[str, Path]:
    """Return the files that come with the suite in a `folder`, by name."""
    return {path.stem: path for path in sorted(folder.glob("*.yaml"))}


def find_stated(name: str, folder: Path, kind: str) -> Path:
    """Return a shipped file, or else the file of the user.

    Parameters
    ----------
    name : of the shipped one, or path of a file
    folder : of the shipped ones
    kind : what such a file states, in a word

    Raises ParameterError where neither is there.
    """
    shipped = shipped_files(folder)
    path = shipped.get(name, Path(name))
    if not path.is_file():
        raise ParameterError(f"{name}: no such {kind} or file; shipped are: {', '.join(shipped)}")
    return path


def read_stated(path: Path, known: Iterable[str], needed: Iterable[str]) -> tuple[bytes, Mapping[str, Any]]:
    """Return text and content of the file at `path`, a mapping.

    Parameters
    ----------
    path : of the file
    known, needed : keys that it may have and must have

    Raises ParameterError, in one line, for what is wrong with it.
    """
    try:
        text = read_given(path)
        content = as_mapping(parse_yaml(text, only_true_and_false=True), str(path))
    except (OSError, ValueError) as error:
        raise (
            error if isinstance(error, ParameterError) else ParameterError(f"{path}: {' '.join(str(error).split())}")
        ) from error
    known = tuple(known)
    refuse_other_kind(content, known, str(path))
    refuse_keys(content, known, str(path))
    for key in needed:
        if not content.get(key):
            raise ParameterError(f"{path}: {key} is missing")
    return text, content


def scenario_of(path: Path, content: Mapping[str, Any]) -> str:
    """Return the scenario that the `content` of the file at `path` names: shipped, or a file beside it."""
    named = str(content["scenario"])
    beside = path.parent / named
    return str(beside) if beside.suffix in (".yaml", ".yml") and beside.is_file() else named


def as_mapping(value: Any, where: str) -> Mapping[str, Any]:
    """Return the `value`, a mapping; raise ParameterError, naming `where` it stands, for another one."""
    if not isinstance(value, Mapping):
        raise ParameterError(f"{where}: must be a mapping, not {value!r}")
    return value


def as_list(value: Any, where: str) -> list[Any]:
    """Return the `value`, a list; raise ParameterError, naming `where` it stands, for another one."""
    if not isinstance(value, list):
        raise ParameterError(f"{where} must be a list")
    return value


def refuse_keys(content: Mapping[str, object], known: Iterable[str], where: str) -> None:
    """Raise ParameterError, naming `where` it stands, for a key of `content` that is not `known`."""
    if unknown := sorted(str(key) for key in set(content) - set(known)):
        raise ParameterError(f"{where}: unknown key {unknown[0]}; known: {', '.join(sorted(known))}")
