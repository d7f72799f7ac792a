"""Units of an FMU's variables: what it declares is converted to the SI unit of the message, or refused.

FMI 2.0 (section 2.2.2, UnitDefinitions): value in SI base units = factor * value + offset, with the exponents of the
base units beside it. A unit that an FMU names and does not define is taken where the suite knows its name.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

from heave_node.files.units import UNITS as NAMED_UNITS

from heave_fmu.variables import UNITS

_BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


class Conversion(NamedTuple):
    """From an FMU's unit to that of the message: SI = factor * value + offset."""

    factor: float = 1.0
    offset: float = 0.0


class OwnVariable(NamedTuple):
    """A variable of an FMU in the place of a message's field."""

    name: str  # of the FMU
    conversion: Conversion = Conversion()  # from its unit to that of the message
    scale: float = 1.0  # its value over that of the message, both in SI units

    def of_message(self, value: Any) -> Any:
        """Return what the FMU is given for the `value` of a message."""
        if self == OwnVariable(self.name) or isinstance(value, str | bool):
            return value
        return (self.scale * value - self.conversion.offset) / self.conversion.factor

    def to_message(self, value: Any) -> Any:
        """Return the value of the message for the FMU's."""
        if self == OwnVariable(self.name) or isinstance(value, str | bool):
            return value
        return (self.conversion.factor * value + self.conversion.offset) / self.scale


def conversion_of(unit: str, own: Any, definitions: Iterable[Any]) -> tuple[Conversion, str]:
    """Return the conversion of a variable of an FMU, and why there is none; "": there is one.

    Parameters
    ----------
    unit : of the message's field, SI; "": none
    own : FMPy's description of the variable
    definitions : units that the FMU defines, as FMPy has them
    """
    declared = own.unit or (own.declaredType.unit if own.declaredType is not None else None)
    if not declared or declared == unit or not unit:
        return Conversion(), ""
    base = next((one.baseUnit for one in definitions if one.name == declared and one.baseUnit is not None), None)
    if base is not None:
        powers = {name: getattr(base, name) or 0 for name in _BASE}
        if powers != {name: UNITS[unit].get(name, 0) for name in _BASE}:
            return Conversion(), f"is in {declared}, and the message in {unit}: they are not of one kind"
        factor = 1.0 if base.factor is None else float(base.factor)
        offset = 0.0 if base.offset is None else float(base.offset)
        if factor == 0.0 or not math.isfinite(factor + offset):
            return Conversion(), f"is in {declared}, whose factor {factor:g} and offset {offset:g} convert nothing"
        return Conversion(factor, offset), ""
    for units in NAMED_UNITS.values():
        if declared in units and unit in units:
            return Conversion(units[declared] / units[unit]), ""
    return Conversion(), f"is in {declared}, which the FMU does not define; the message is in {unit}"
