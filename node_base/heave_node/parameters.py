"""Node parameters as frozen dataclasses: every value has a type, a unit, a range and a description, and is checked
once.

A parameter set is a frozen dataclass whose fields are made by `parameter`. A field whose type is itself a parameter
set is a group;
its members have dotted names (`unit.mass`). Pure Python: components and design tools use this without ROS.

>>> @dataclass(frozen=True)
... class Winch:
...     speed_limit: float = parameter(2.0, unit="m/s", minimum=0.0, description="Largest payout speed.")
>>> build_parameters(Winch, {"speed_limit": 1}, where="my.yaml: winch")
Winch(speed_limit=1.0)
"""

from __future__ import annotations

import dataclasses
import difflib
import math
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

T = TypeVar("T")

Scalar = bool | int | float | str
Value = Scalar | tuple[Scalar, ...]


class ParameterError(ValueError):
    """A parameter that cannot be used; the message says where it stands, its name, its value and what is allowed."""


@dataclass(frozen=True)
class ParameterInfo:
    """What is known of one parameter: enough for a ROS descriptor, a table in a README, and a check."""

    name: str
    type: type
    """bool, int, float or str; of the elements where `is_array`."""
    is_array: bool
    default: Value
    unit: str
    description: str
    minimum: float | None = None
    maximum: float | None = None
    choices: tuple[str, ...] = ()
    length: int | None = None

    def allowed(self) -> str:
        """Say in words what values are allowed."""
        kind = {bool: "true or false", int: "a whole number", float: "a number", str: "a text"}[self.type]
        if self.choices:
            kind = "one of " + ", ".join(self.choices)
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
        """Return `value` as this parameter's type, or raise ParameterError.

        A whole number is taken for a float; nothing else is converted. NaN and infinity are never legal.
        """
        if not self.is_array:
            return self._check_scalar(value, where=where)
        if isinstance(value, str | bytes) or not hasattr(value, "__iter__"):
            raise self._refusal(value, where)
        elements = tuple(self._check_scalar(element, where=where) for element in value)
        if self.length is not None and len(elements) != self.length:
            raise self._refusal(list(elements), where)
        return elements

    def _check_scalar(self, value: object, *, where: str) -> Scalar:
        if self.type is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if self.type is str and isinstance(value, bool) and ("on" if value else "off") in self.choices:
            value = "on" if value else "off"  # YAML reads a bare off as false
        is_right_type = isinstance(value, self.type) and not (self.type is int and isinstance(value, bool))
        if not is_right_type or (isinstance(value, float) and not math.isfinite(value)):
            raise self._refusal(value, where)
        assert isinstance(value, bool | int | float | str)
        if self.choices and value not in self.choices:
            raise self._refusal(value, where)
        if isinstance(value, int | float) and not self._in_range(value):
            raise self._refusal(value, where)
        return value

    def _in_range(self, value: float) -> bool:
        return (self.minimum is None or value >= self.minimum) and (self.maximum is None or value <= self.maximum)

    def _refusal(self, value: object, where: str) -> ParameterError:
        return ParameterError(f"{where}: {self.name} = {value!r} is not allowed: it must be {self.allowed()}")


def parameter(
    default: Any,
    *,
    unit: str,
    description: str,
    minimum: float | None = None,
    maximum: float | None = None,
    choices: tuple[str, ...] = (),
    length: int | None = None,
) -> Any:
    """Return a dataclass field that is one node parameter.

    `unit` is SI, "" for a pure number or a text; `minimum` and `maximum` are inclusive and hold for each element of a
    list; `length` fixes
    the number of elements of a list.
    """
    metadata = {
        "unit": unit,
        "description": description,
        "minimum": minimum,
        "maximum": maximum,
        "choices": choices,
        "length": length,
    }
    return dataclasses.field(default=default, metadata={"parameter": metadata})


def group(parameters_type: type[T], **overrides: Any) -> T:
    """Return a dataclass field that holds the parameter set `parameters_type`; `overrides` change its defaults here."""
    return dataclasses.field(default_factory=lambda: parameters_type(**overrides))


def describe(parameters_type: type, prefix: str = "", defaults: object | None = None) -> list[ParameterInfo]:
    """List the parameters of a parameter set, groups flattened to dotted names, in the order of definition."""
    hints = typing.get_type_hints(parameters_type)
    defaults = parameters_type() if defaults is None else defaults
    infos: list[ParameterInfo] = []
    for field in dataclasses.fields(parameters_type):
        default = getattr(defaults, field.name)
        hint = hints[field.name]
        if dataclasses.is_dataclass(hint):
            assert isinstance(hint, type)
            infos += describe(hint, f"{prefix}{field.name}.", default)
            continue
        is_array = typing.get_origin(hint) is tuple
        element = typing.get_args(hint)[0] if is_array else hint
        metadata = field.metadata["parameter"]
        infos.append(ParameterInfo(prefix + field.name, element, is_array, default, **metadata))
    return infos


def flatten(parameters: object, prefix: str = "") -> dict[str, Value]:
    """Return the dotted names and values of a parameter set; the inverse of `build_parameters`."""
    values: dict[str, Value] = {}
    for field in dataclasses.fields(parameters):  # type: ignore[arg-type]
        value = getattr(parameters, field.name)
        if dataclasses.is_dataclass(value):
            values |= flatten(value, f"{prefix}{field.name}.")
        else:
            values[prefix + field.name] = value
    return values


def build_parameters(parameters_type: type[T], values: Mapping[str, object], *, where: str) -> T:
    """Make the parameter set `parameters_type` from dotted names and values; what is not named keeps its default.

    Raises ParameterError for a name that does not exist, a wrong type, a value out of range, or a set that contradicts
    itself (a ValueError of
    a dataclass's `__post_init__`). `where` opens the message: file and node.
    """
    infos = {info.name: info for info in describe(parameters_type)}
    for name in values:
        if name not in infos:
            near = difflib.get_close_matches(name, infos, n=1)
            hint = f"; did you mean {near[0]}?" if near else f"; known: {', '.join(sorted(infos))}"
            raise ParameterError(f"{where}: there is no parameter {name}{hint}")
    checked = {name: infos[name].check(value, where=where) for name, value in values.items()}
    try:
        return _replace(parameters_type(), checked)
    except ParameterError:
        raise
    except ValueError as error:
        raise ParameterError(f"{where}: {error}") from error


def _replace(parameters: T, values: Mapping[str, Value]) -> T:
    """Return a copy of the set with `values` (dotted names) in place."""
    own = {name: value for name, value in values.items() if "." not in name}
    groups = {name.split(".", 1)[0] for name in values if "." in name}
    changes: dict[str, Any] = dict(own)
    for name in groups:
        inner = {key.split(".", 1)[1]: value for key, value in values.items() if key.startswith(name + ".")}
        changes[name] = _replace(getattr(parameters, name), inner)
    return dataclasses.replace(parameters, **changes)  # type: ignore[type-var]
