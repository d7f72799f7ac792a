"""Docstrings say what every argument is, and their examples run.

A public function, method or class names each of its arguments: in a list under `Parameters` (or `Attributes`), or,
where there is no such list, in its text. A list names every argument and nothing else. The fields of a dataclass are
arguments too, unless a comment behind the field or above it says what it is, and of a float in which unit (`[-]`: in
none), or it is a node parameter with its own description. A module's docstring may say, after the word `Arguments`,
what its functions have in common, or that they are `as in` a module beside it, or in one named with dots from a folder
above. A docstring that begins with `See` hands over to another one.
"""

from __future__ import annotations

import ast
import doctest
import importlib
import io
import re
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = {
    "node_base": "heave_node",
    "wave_vessel_node": "wave_vessel_node",
    "cable_sim_node": "cable_sim_node",
    "winch_controller_node": "winch_controller_node",
    "bags": "heave_bags",
    "bringup": "heave_bringup",
    **{f"extras/{name}": f"heave_{name}" for name in ("devices", "studies", "statics", "drives", "panel", "fmu")},
}


def module_name(path: Path) -> str:
    """Return the dotted name of the module in a file."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    parts = parts[2:] if parts[0] == "extras" else parts[1:]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


SOURCES = [path for folder, package in PACKAGES.items() for path in sorted((ROOT / folder / package).rglob("*.py"))]
WITH_EXAMPLES = [path for path in SOURCES if ">>> " in path.read_text(encoding="utf-8")]

_HEADING = re.compile(r"^(\w[\w ]*)\n-{3,}$", re.MULTILINE)
_ENTRY = re.compile(r"(?:^|; )(\w+(?:, \w+)*) : ")
_PARAMETER_MAKERS = ("parameter", "group")
_UNIT = re.compile(r"\[|\bSI\b|in (the|its|their) unit\b|in `unit`|see `")
"""What the meaning of a float must hold: its unit, that it is in SI, or where the unit is found."""


@dataclass(frozen=True)
class Documented:
    """A function or class, its docstring, and the arguments that the docstring must name."""

    name: str
    text: str
    arguments: tuple[str, ...]
    others: tuple[str, ...] = ()  # names that a list may hold besides: attributes that are no arguments
    common: str = ""  # docstring of the module, on arguments that its functions have in common
    without_unit: tuple[str, ...] = ()  # fields that a comment explains without a unit


@dataclass(frozen=True)
class Comments:
    """The comments of a module: where the meaning of a field may stand."""

    behind: dict[int, str]  # those beside code, by line
    alone: dict[int, str]  # those on a line of their own, by line

    @classmethod
    def of(cls, source: str) -> Comments:
        comments = cls({}, {})
        for token in tokenize.generate_tokens(io.StringIO(source).readline):
            if token.type == tokenize.COMMENT:
                is_behind = bool(token.line[: token.start[1]].strip())
                (comments.behind if is_behind else comments.alone)[token.start[0]] = token.string
        return comments

    def meaning(self, field: ast.AnnAssign) -> str:
        """Return the comment behind a field, or else the one above it."""
        behind = re.sub(r"# (type: ignore|noqa|fmt: skip).*", "", self.behind.get(field.end_lineno or 0, ""))
        above, line = [], field.lineno - 1
        while line in self.alone:
            above.append(self.alone[line])
            line -= 1
        return behind or " ".join(reversed(above))


def documented(path: Path) -> Iterator[Documented]:
    """Yield the public functions and classes of a module that have a docstring."""
    source = path.read_text(encoding="utf-8")
    common = common_arguments(path)
    for item in _of_body(ast.parse(source).body, "", Comments.of(source)):
        yield replace(item, common=common)


def common_arguments(path: Path) -> str:
    """Return what a module says of the arguments that its functions have in common."""
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    common = "\n".join(re.findall(r"\bArguments\b.*?(?=\n\n|\Z)", text, re.DOTALL))
    other = re.search(r"\bas in `([\w.]+)`", common)
    if other is None:
        return common
    file = other[1].replace(".", "/") + ".py"
    return common + common_arguments(next(folder / file for folder in path.parents if (folder / file).exists()))


def _of_body(body: list[ast.stmt], prefix: str, comments: Comments) -> Iterator[Documented]:
    for node in body:
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            text = ast.get_docstring(node)
            if text and not text.startswith("See "):
                yield Documented(prefix + node.name, text, _arguments(node, is_method=bool(prefix)))
        elif isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            text = ast.get_docstring(node)
            if text and not text.startswith("See "):
                yield Documented(
                    prefix + node.name,
                    text,
                    _class_arguments(node, comments),
                    _attributes(node),
                    without_unit=tuple(_without_unit(node, comments)),
                )
            yield from _of_body(node.body, f"{prefix}{node.name}.", comments)


def _arguments(function: ast.FunctionDef, *, is_method: bool) -> tuple[str, ...]:
    given = function.args
    names = [argument.arg for argument in (*given.posonlyargs, *given.args)]
    is_static = any(isinstance(mark, ast.Name) and mark.id == "staticmethod" for mark in function.decorator_list)
    if is_method and not is_static:
        names = names[1:]
    names += [argument.arg for argument in (*given.kwonlyargs, given.vararg, given.kwarg) if argument is not None]
    return tuple(name for name in names if not name.startswith("_"))


def _without_unit(node: ast.ClassDef, comments: Comments) -> Iterator[str]:
    """Yield the public fields of a class that are floats and whose comment names no unit."""
    for child in node.body:
        if not isinstance(child, ast.AnnAssign) or not isinstance(child.target, ast.Name):
            continue
        is_float = re.fullmatch(r"float( \| None)?", ast.unparse(child.annotation)) is not None
        meaning = comments.meaning(child)
        if is_float and meaning and child.target.id[0] != "_" and not _UNIT.search(meaning):
            yield child.target.id


def _class_arguments(node: ast.ClassDef, comments: Comments) -> tuple[str, ...]:
    """Return the fields of a dataclass that are said nowhere else, or the arguments of `__init__`."""
    if not _is_dataclass(node):
        for child in node.body:
            if isinstance(child, ast.FunctionDef) and child.name == "__init__":
                return _arguments(child, is_method=True)
        return ()
    fields = []
    for child, following in zip_longest(node.body, node.body[1:]):
        if not isinstance(child, ast.AnnAssign) or not isinstance(child.target, ast.Name):
            continue
        is_said_below = isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant)
        is_said = is_said_below or bool(comments.meaning(child))
        if not (is_said or _is_class_variable(child) or _is_node_parameter(child)):
            fields.append(child.target.id)
    return tuple(name for name in fields if not name.startswith("_"))


def _attributes(node: ast.ClassDef) -> tuple[str, ...]:
    """Return every name that an object of a class may be asked for."""
    names = []
    for child in ast.walk(node):
        if isinstance(child, ast.Attribute) and isinstance(child.value, ast.Name) and child.value.id == "self":
            names.append(child.attr)
        elif isinstance(child, ast.AnnAssign) and isinstance(child.target, ast.Name):
            names.append(child.target.id)
        elif isinstance(child, ast.Assign):
            names += [target.id for target in child.targets if isinstance(target, ast.Name)]
    return tuple(names)


def _is_dataclass(node: ast.ClassDef) -> bool:
    marks = [mark.func if isinstance(mark, ast.Call) else mark for mark in node.decorator_list]
    bases = [base.id for base in node.bases if isinstance(base, ast.Name)]
    return any(isinstance(mark, ast.Name) and mark.id == "dataclass" for mark in marks) or "NamedTuple" in bases


def _is_class_variable(field: ast.AnnAssign) -> bool:
    return "ClassVar" in ast.unparse(field.annotation) or "init=False" in (
        ast.unparse(field.value) if field.value else ""
    )


def _is_node_parameter(field: ast.AnnAssign) -> bool:
    made_by = field.value.func if isinstance(field.value, ast.Call) else None
    return isinstance(made_by, ast.Name) and made_by.id in _PARAMETER_MAKERS


def listed(text: str) -> list[str] | None:
    """Return the names listed under Parameters and Attributes, None where there is no list."""
    headings = list(_HEADING.finditer(text))
    names: list[str] = []
    has_list = False
    for heading, following in zip_longest(headings, headings[1:]):
        if heading[1] not in ("Parameters", "Attributes"):
            continue
        has_list = True
        end = following.start() if following is not None else len(text)
        for line in text[heading.end() : end].split("\n\n", maxsplit=1)[0].splitlines():
            if not line.startswith(" "):
                names += [name for entry in _ENTRY.finditer(line) for name in entry[1].split(", ")]
    return names if has_list else None


def faults_of(item: Documented) -> list[str]:
    """Say what is wrong with a docstring."""
    names = listed(item.text)
    without_unit = [f"{item.name}: {name} has no unit" for name in item.without_unit]
    if names is None:
        return without_unit + [
            f"{item.name}: {name} is not named"
            for name in item.arguments
            if not re.search(rf"\b{name}\b", item.text) and f"`{name}`" not in item.common
        ]
    missing = [name for name in item.arguments if name not in names and f"`{name}`" not in (item.text + item.common)]
    foreign = [name for name in names if name not in (*item.arguments, *item.others)]
    twice = sorted({name for name in names if names.count(name) > 1})
    return (
        without_unit
        + [f"{item.name}: {name} is not listed" for name in missing]
        + [f"{item.name}: {name} is listed, but is no argument" for name in foreign]
        + [f"{item.name}: {name} is listed twice" for name in twice]
    )


@pytest.mark.parametrize("path", SOURCES, ids=module_name)
def test_docstrings_name_every_argument_and_no_other(path):
    faults = [fault for item in documented(path) for fault in faults_of(item)]
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize("path", WITH_EXAMPLES, ids=module_name)
def test_the_examples_in_docstrings_run(path):
    assert doctest.testmod(importlib.import_module(module_name(path))).failed == 0


@pytest.mark.parametrize(
    ("function", "fault"),
    [
        ('def f(a, b):\n    """Return a."""', "f: b is not named"),
        ('def f(a):\n    """Return.\n\n    Parameters\n    ----------\n    b : [m]\n    """', "f: a is not listed"),
        (
            'def f(a):\n    """R.\n\n    Parameters\n    ----------\n    a, b : [m]\n    """',
            "f: b is listed, but is no argument",
        ),
        ('class F:\n    """A thing."""\n    def __init__(self, mass): ...', "F: mass is not named"),
        ('@dataclass\nclass F:\n    """A thing."""\n    mass: float', "F: mass is not named"),
        ('@dataclass\nclass F:\n    """A thing."""\n    mass: float  # of it', "F: mass has no unit"),
        ('class F(NamedTuple):\n    """A thing."""\n    # of it\n    mass: float = 1.0', "F: mass has no unit"),
        (
            '@dataclass\nclass F:\n    """A thing."""\n    mass: float  # of it [kg]\n    name: str',
            "F: name is not named",
        ),
        ('@dataclass\nclass F:\n    """A thing."""\n    mass: float  # noqa: A003', "F: mass is not named"),
    ],
)
def test_the_check_finds(tmp_path, function, fault):
    path = tmp_path / "module.py"
    path.write_text(function)
    assert fault in [found for item in documented(path) for found in faults_of(item)]
