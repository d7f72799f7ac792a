"""The one reader of YAML: plain values of bounded size and depth, read as the parameter reader of ROS 2 does.

A file may come from anyone. A text that would expand (aliases), make objects (tags) or nest without end is refused in
one line. `1e-5` is a number, `1:30:00` and `1996-06-14` are texts, every key is a text, and a key that appears twice is
refused: the first of its values would be lost silently.

>>> parse_yaml("{speed: 1e-1, at: 1:30:00}")
{'speed': 0.1, 'at': '1:30:00'}
"""

from __future__ import annotations

import math
import re
from typing import Any

import yaml

LARGEST_YAML = 8 << 20
"""Bytes of a text: the metadata of a bag with many topics and splits has one or two million."""
MOST_VALUES = 250_000
"""Names and values in a text: two seconds to read. A bag of 10,000 splits has 150,000."""
DEEPEST_YAML = 32
"""Mappings and sequences within each other."""
LONGEST_KEY = 200
"""Characters of a name."""
LONGEST_NUMBER = 400
"""Characters of a number: no 64 bits hold a longer one."""

EXPONENT = re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$")
"""A number with an exponent that YAML 1.1 takes for a text, and ROS 2 does not."""

_TAG = "tag:yaml.org,2002:"
_PLAIN = frozenset(_TAG + kind for kind in ("str", "int", "float", "bool", "null", "seq", "map"))
_INT64 = range(-(1 << 63), 1 << 63)
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml, ten times as fast
DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
"""Writes plain values; libyaml gives the same text in a quarter of the time."""
_WRONG = (yaml.YAMLError, ArithmeticError, LookupError, TypeError, ValueError, AttributeError)


class YamlError(ValueError):
    """A text that is no YAML, or more than it may be; the message is one line."""


class _RosLoader(_LOADER):  # type: ignore[misc]  # one of two
    """Reads numbers and names as ROS 2 does."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Return a mapping whose keys are texts, each there once.

        Parameters
        ----------
        node : of the YAML document
        deep : whether nested values are made at once
        """
        if not isinstance(node, yaml.MappingNode):
            raise YamlError(f"what is tagged as a mapping on line {node.start_mark.line + 1} is none")
        seen: set[str] = set()
        for key, _ in node.value:
            where = f"on line {key.start_mark.line + 1}"
            if not isinstance(key, yaml.ScalarNode):
                raise YamlError(f"a name {where} is no text")
            if len(key.value) > LONGEST_KEY or not key.value.isprintable():
                raise YamlError(f"the name {key.value[:40]!r} {where} is too long, or not printable")
            if key.value in seen:
                raise YamlError(f"{key.value} appears twice, again {where}")
            key.tag = f"{_TAG}str"
            seen.add(key.value)
        mapping: dict[Any, Any] = super().construct_mapping(node, deep)
        return mapping


class _WordsLoader(_RosLoader):
    """Reads `on`, `off`, `yes` and `no` as words: only `true` and `false` are truth values, as in YAML 1.2."""


def _whole(loader: _RosLoader, node: yaml.ScalarNode) -> int | float:
    """Return a whole number; beyond 64 bits it is a decimal one, as for ROS 2."""
    _check_length(node)
    value: int = loader.construct_yaml_int(node)
    return value if value in _INT64 else _finite(float(value), node)


def _decimal(loader: _RosLoader, node: yaml.ScalarNode) -> float:
    _check_length(node)
    value: float = loader.construct_yaml_float(node)
    return value if "inf" in node.value.lower() else _finite(value, node)


def _check_length(node: yaml.ScalarNode) -> None:
    if len(node.value) > LONGEST_NUMBER:
        raise YamlError(f"the number {node.value[:20]}... on line {node.start_mark.line + 1} is too long")


def _finite(value: float, node: yaml.ScalarNode) -> float:
    if math.isinf(value):
        raise YamlError(f"the number {node.value} on line {node.start_mark.line + 1} is too large")
    return value


def _set_up() -> None:
    """Take times and numbers to the base 60 out of what is recognised, put numbers with an exponent in."""
    kept = {f"{_TAG}{kind}" for kind in ("bool", "int", "float", "null")}
    whole = re.compile(r"^[-+]?(0b[01][01_]*|0[0-7_]*|[1-9][0-9_]*|0x[0-9a-fA-F][0-9a-fA-F_]*)$")
    decimal = re.compile(r"^([-+]?[0-9][0-9_]*\.[0-9_]*|[-+]?\.[0-9][0-9_]*|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))$")
    ours = {f"{_TAG}int": whole, f"{_TAG}float": decimal}
    _RosLoader.yaml_implicit_resolvers = {
        first: [(tag, ours.get(tag, form)) for tag, form in resolvers if tag in kept]
        for first, resolvers in _LOADER.yaml_implicit_resolvers.items()
    }
    _RosLoader.add_implicit_resolver(f"{_TAG}float", EXPONENT, list("-+.0123456789"))
    _WordsLoader.yaml_implicit_resolvers = {
        first: [(tag, form) for tag, form in resolvers if tag != f"{_TAG}bool"]
        for first, resolvers in _RosLoader.yaml_implicit_resolvers.items()
    }
    words = re.compile(r"^(true|True|TRUE|false|False|FALSE)$")
    _WordsLoader.add_implicit_resolver(f"{_TAG}bool", words, list("tTfF"))
    _RosLoader.add_constructor(f"{_TAG}int", _whole)
    _RosLoader.add_constructor(f"{_TAG}float", _decimal)


_set_up()


def parse_yaml(text: str | bytes, *, only_true_and_false: bool = False, most_values: int = MOST_VALUES) -> Any:
    """Return the value of a YAML text, numbers as ROS 2 reads them.

    Parameters
    ----------
    text : a document; bytes are UTF-8
    only_true_and_false : `off` is a word, not a truth value as ROS 2 and YAML 1.1 have it
    most_values : names and values that it may have

    Raises YamlError, in one line, if it is none, exceeds a bound, or uses aliases, or tags but those of plain values.
    """
    if len(text) > LARGEST_YAML:
        raise YamlError(f"it has {len(text)} characters, {LARGEST_YAML} are allowed")
    words = ""
    try:
        words = text if isinstance(text, str) else text.decode()
        _check_events(words, most_values)
        return yaml.load(words, Loader=_WordsLoader if only_true_and_false else _RosLoader)
    except YamlError:
        raise
    except _WRONG as error:
        raise YamlError(_complaint(error, words)) from error


def _complaint(error: Exception, text: str) -> str:
    """Return what is wrong with a `text` that is no YAML: the line, what to look at, and the parser's own words."""
    mark = getattr(error, "problem_mark", None)
    if isinstance(error, UnicodeDecodeError):
        return f"it is not text in UTF-8 (byte {error.object[error.start]:#x} at {error.start}); save it as UTF-8"
    if mark is None:
        return f"it is not valid YAML: {' '.join(str(error).split())[:500]}"
    lines = text.splitlines()
    line = lines[mark.line] if mark.line < len(lines) else ""
    is_tab = "\t" in line[: len(line) - len(line.lstrip())]
    hint = "indent with spaces, not tabs" if is_tab else "check its indentation, quotes and brackets"
    at = min(mark.line + 1, len(lines))  # an end that is missing is missed after the last line
    return f"line {at} is not valid YAML: {hint} ({getattr(error, 'problem', None) or 'unknown'})"


def _check_events(text: str, most_values: int) -> None:
    """Hold a text to the bounds before anything is parsed."""
    depth = 0
    for number, event in enumerate(yaml.parse(text, Loader=_RosLoader)):
        if number > most_values:
            raise YamlError(f"it has more than {most_values} values")
        if isinstance(event, yaml.AliasEvent):
            raise YamlError("it uses aliases")
        if isinstance(event, yaml.NodeEvent) and getattr(event, "tag", None) not in (None, *_PLAIN):
            raise YamlError(f"it uses the tag {str(event.tag)[:80]!r}")
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        if depth > DEEPEST_YAML:
            raise YamlError(f"it is more than {DEEPEST_YAML} levels deep")
