"""Node parameters as frozen dataclasses: each value has a type, a unit, a range and a description, and is checked once.

A parameter set is a frozen dataclass whose fields are made by `parameter`. A field whose type is itself a parameter
set is a group; its members have dotted names (`unit.mass`). A field that is made otherwise is no parameter: its default
is a constant of every run, which tests and published models may replace. Pure Python: components and design tools use
it without ROS.

>>> @dataclass(frozen=True)
... class Winch:
...     speed_limit: float = parameter(2.0, "m/s", 0.0, None, "Largest payout speed.")
>>> build_parameters(Winch, {"speed_limit": 1}, where="my.yaml: winch")
Winch(speed_limit=1.0)
"""

from __future__ import annotations

import dataclasses
import difflib
import functools
import math
import re
import typing
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from heave_node.bare_words import word_meant

T = TypeVar("T")

Scalar = bool | int | float | str
Value = Scalar | tuple[Scalar, ...]


class ParameterError(ValueError):
    """A parameter that cannot be used; the message says where it is, its name, its value and what is allowed."""


@dataclass(frozen=True)
class Given:
    """A value as the user gave it, with what an error message must say about it."""

    value: object  # as read, not yet checked
    name: str  # name that the user wrote, for example `system.sea.peak_period`
    where: str  # where it was given: file and section, or the option of the command line
    reader: str = ""  # node that cannot take the value, where the name alone does not say it


@dataclass(frozen=True)
class ParameterInfo:
    """What is known of one parameter: enough for a ROS descriptor, a table in a README, and a check."""

    name: str  # dotted name
    type: type  # bool, int, float or str; of the elements of a list
    is_array: bool  # whether it is a list
    default: Value  # value where none is given
    unit: str  # SI unit, "" for a pure number or a string
    description: str  # what it is, in one sentence
    minimum: float | None = None  # inclusive bound, of each element of a list, in the unit of the parameter
    maximum: float | None = None  # inclusive bound, of each element of a list, in the unit of the parameter
    choices: tuple[str, ...] = ()  # the strings that are allowed; () allows any
    length: int | None = None  # number of elements of a list; None allows any
    is_live: bool = False  # may be changed while the node runs
    also: str = ""  # regular expression of strings that are allowed beside the choices; "": none
    also_words: str = ""  # what these strings are

    def allowed(self) -> str:
        """Describe what values are allowed."""
        kind = {bool: "true or false", int: "a whole number", float: "a number", str: "a string"}[self.type]
        if self.choices:
            kind = "one of " + ", ".join(self.choices) + (f"; or {self.also_words}" if self.also else "")
        elif self.minimum is not None and self.maximum is not None:
            kind += f" from {self.minimum:g} to {self.maximum:g}"
        elif self.minimum is not None:
            kind += f" of at least {self.minimum:g}"
        elif self.maximum is not None:
            kind += f" of at most {self.maximum:g}"
        if self.unit:
            kind += f" [{self.unit}]"
        if self.is_array:
            kind = f"a list of {self.length if self.length is not None else 'any number of'} values, each {kind}"
        return kind

    def check(self, value: object, *, where: str) -> Value:
        """Return a value as this parameter's type, or raise ParameterError.

        A whole number is taken for a float, and what a bare word is read as for the word, where it is a choice: false
        for off. Nothing else is converted. NaN and infinity are never legal numbers.

        Parameters
        ----------
        value : to be checked
        where : opens the error message
        """
        return self.check_given(Given(value, self.name, where))

    def check_given(self, given: Given) -> Value:
        """Return the given value as this parameter's type, or raise ParameterError in the user's words."""
        if not self.is_array:
            return self._check_scalar(given.value, given)
        if isinstance(given.value, str | bytes) or not hasattr(given.value, "__iter__"):
            raise self._refusal(given.value, given)
        elements = tuple(self._check_scalar(element, given) for element in given.value)
        if self.length is not None and len(elements) != self.length:
            raise self._refusal(list(elements), given)
        return elements

    def _check_scalar(self, value: object, given: Given) -> Scalar:
        if self.type is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if self.type is str and not isinstance(value, str):
            value = word_meant(value, self.choices) or value
        is_right_type = isinstance(value, self.type) and not (self.type is int and isinstance(value, bool))
        if not is_right_type or (isinstance(value, float) and not math.isfinite(value)):
            raise self._refusal(value, given)
        assert isinstance(value, bool | int | float | str)
        if self.choices and value not in self.choices and not (self.also and re.fullmatch(self.also, str(value))):
            raise self._refusal(value, given)
        if isinstance(value, int | float) and not self._in_range(value):
            raise self._refusal(value, given)
        return value

    def _in_range(self, value: float) -> bool:
        return (self.minimum is None or value >= self.minimum) and (self.maximum is None or value <= self.maximum)

    def _refusal(self, value: object, given: Given) -> ParameterError:
        reader = f" for {given.reader}" if given.reader else ""
        quotes = "" if self.type is not str or self.choices or isinstance(value, str) else f', in quotes: "{value}"'
        return ParameterError(
            f"{given.where}: {given.name} = {value!r} is not allowed{reader}: it must be {self.allowed()}{quotes}"
        )


def parameter(
    default: Any,
    unit: str = "",
    minimum: float | None = None,
    maximum: float | None = None,
    description: str = "",
    *,
    choices: tuple[str, ...] = (),
    length: int | None = None,
    is_live: bool = False,
    also: str = "",
    also_words: str = "",
) -> Any:
    """Return a dataclass field that is one node parameter, a row: default, unit, bounds, meaning.

    Parameters
    ----------
    default : value where none is given; a tuple makes the parameter a list
    unit : SI unit, "" for a pure number or a string
    minimum, maximum : inclusive bounds, of each element of a list; None: no bound
    description : what it is, in one sentence; every parameter has one
    choices : the strings that are allowed; () allows any
    length : number of elements of a list; None allows any
    is_live : may be changed while the node runs: by ROS's own service
    also, also_words : regular expression of strings that are allowed beside the choices, and what they are; "": none
    """
    assert description, "a parameter says what it is"
    metadata = {
        "unit": unit,
        "description": description,
        "minimum": minimum,
        "maximum": maximum,
        "choices": choices,
        "length": length,
        "is_live": is_live,
        "also": also,
        "also_words": also_words,
    }
    return dataclasses.field(default=default, metadata={"parameter": metadata})


def group(parameters_type: type[T], **overrides: Any) -> T:
    """Return a dataclass field that holds the parameter set `parameters_type`; `overrides` change its defaults here."""
    return dataclasses.field(default_factory=lambda: parameters_type(**overrides))


def describe(parameters_type: type) -> list[ParameterInfo]:
    """List the parameters of `parameters_type`, groups flattened to dotted names, in the order of definition."""
    return list(_described(parameters_type))


@functools.cache
def _described(parameters_type: type) -> tuple[ParameterInfo, ...]:
    return tuple(_infos(parameters_type, "", parameters_type()))


def _infos(parameters_type: type, prefix: str, defaults: object) -> Iterator[ParameterInfo]:
    """Yield what is known of each parameter; a group's defaults are those of the set that holds it."""
    hints = typing.get_type_hints(parameters_type)
    for field in dataclasses.fields(parameters_type):
        default = getattr(defaults, field.name)
        hint = hints[field.name]
        if dataclasses.is_dataclass(hint):  # the group that is there may be narrower than its hint
            yield from _infos(type(default), f"{prefix}{field.name}.", default)
        elif "parameter" in field.metadata:
            yield _info(field, hint, prefix + field.name, default)


class Checked:
    """A parameter set whose values are in range wherever it is made; checks of its own follow `check_ranges`."""

    def __post_init__(self) -> None:
        check_ranges(self)


def check_ranges(parameters: object) -> None:
    """Raise ParameterError for a value of `parameters` that is of a wrong type or out of range; for `__post_init__`.

    So the ranges hold wherever a set is made, not only where it is read from a file. Groups check themselves.
    """
    own: type = type(parameters)
    for info in _own_infos(own):
        info.check(getattr(parameters, info.name), where=own.__name__)


@functools.cache
def _own_infos(parameters_type: type) -> tuple[ParameterInfo, ...]:
    hints = typing.get_type_hints(parameters_type)
    return tuple(
        _info(field, hints[field.name], field.name, field.default)
        for field in dataclasses.fields(parameters_type)
        if "parameter" in field.metadata
    )


def _info(field: dataclasses.Field[Any], hint: Any, name: str, default: Any) -> ParameterInfo:
    is_array = typing.get_origin(hint) is tuple
    element = typing.get_args(hint)[0] if is_array else hint
    return ParameterInfo(name, element, is_array, default, **field.metadata["parameter"])


def flatten(parameters: object, prefix: str = "") -> dict[str, Value]:
    """Return the dotted names and values of a parameter set; the inverse of `build_parameters`.

    Parameters
    ----------
    parameters : the parameter set
    prefix : put before every name
    """
    values: dict[str, Value] = {}
    for field in dataclasses.fields(parameters):  # type: ignore[arg-type]
        value = getattr(parameters, field.name)
        if dataclasses.is_dataclass(value):
            values |= flatten(value, f"{prefix}{field.name}.")
        elif "parameter" in field.metadata:
            values[prefix + field.name] = value
    return values


def build_parameters(parameters_type: type[T], values: Mapping[str, object], *, where: str) -> T:
    """Make a parameter set from dotted names and values; what is not named keeps its default.

    Parameters
    ----------
    parameters_type : the parameter set to make
    values : by dotted name
    where : opens error messages: file and node

    Raises
    ------
    ParameterError
        For an unknown name, a wrong type, a value out of range, or a set that contradicts itself (a ValueError from
        a dataclass's `__post_init__`).
    """
    return build_given(
        parameters_type, {name: Given(value, name, where) for name, value in values.items()}, where=where
    )


def build_given(parameters_type: type[T], given: Mapping[str, Given], *, where: str) -> T:
    """Make a parameter set like `build_parameters`, from values that know where the user gave them.

    Parameters
    ----------
    parameters_type : the parameter set to make
    given : values by dotted name
    where : opens the message for a set that contradicts itself; a single wrong value is reported with its own origin
    """
    infos = {info.name: info for info in describe(parameters_type)}
    for name, value in given.items():
        if name not in infos:
            raise unknown_parameter(value, infos)
    checked = {name: infos[name].check_given(value) for name, value in given.items()}
    try:
        return _replace(parameters_type(), checked)
    except ValueError as error:
        raise ParameterError(f"{where}: {error}") from error


LONGEST_LIST = 20
"""Most names that an error message lists in full; of more, only the first word of each."""


def unknown_parameter(given: Given, known: Iterable[str]) -> ParameterError:
    """Return the error for an unknown name, with the nearest known one where there is one.

    Parameters
    ----------
    given : what the user gave
    known : all names that are allowed
    """
    names = sorted(known)
    near = difflib.get_close_matches(given.name, names, n=1)
    group = given.name.partition(".")[0]
    names = [name for name in names if name.partition(".")[0] == group] or names
    if len(names) > LONGEST_LIST:
        names = sorted({name.partition(".")[0] for name in names})
    hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(names)}"
    return ParameterError(f"{given.where}: there is no parameter {given.name}; {hint}")


def _replace(parameters: T, values: Mapping[str, Value]) -> T:
    """Return a copy of the set with `values` (dotted names) in place."""
    own = {name: value for name, value in values.items() if "." not in name}
    groups = {name.split(".", 1)[0] for name in values if "." in name}
    changes: dict[str, Any] = dict(own)
    for name in groups:
        inner = {key.split(".", 1)[1]: value for key, value in values.items() if key.startswith(name + ".")}
        changes[name] = _replace(getattr(parameters, name), inner)
    return dataclasses.replace(parameters, **changes)  # type: ignore[type-var]
