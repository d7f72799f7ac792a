"""A winch drive given as an FMU, in the place of `virtual_winch`.

Its variables are those of the messages, `winch.command.payout_rate` among them, or are named in a map. It needs one of
the set-points in and one of the payouts out; the rest is filled in: an encoder reads the payout, a rate is its
difference, the brake does what is ordered, no fault is known.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from cable_sim_node.conversions import WINCH_COMMAND, WINCH_STATE
from cable_sim_node.winch.command_line import WinchCommand
from cable_sim_node.winch.component import WinchState
from heave_bringup.errors import CommandError
from heave_node.extras import how_to_install
from heave_node.files.bounded_yaml import YamlError, parse_yaml
from heave_node.interface import topics
from heave_node.interface.sensors import WireReading
from heave_node.parameters import ParameterError

from heave_fmu.archive import FmuRefusedError, described, unpack_fmu
from heave_fmu.instance import FmuInstance
from heave_fmu.ports import Port
from heave_fmu.unit_conversion import OwnVariable, conversion_of
from heave_fmu.variables import BOOLEAN, INTEGER, REAL, Variable

WINCH = "virtual_winch"
NODE = "heave_fmu.winch_node"
"""Module that runs a drive."""
FMU, MAP = ".fmu", ".yaml"
"""Endings of an FMU of a drive, and of a map that names one."""
_KEYS = ("fmu", "variables", "start")
_SET_POINTS = ("winch.command.payout_rate", "winch.command.payout")
_PAYOUTS = ("winch.state.payout", "winch.state.encoder_payout")
_WIDTHS = {BOOLEAN: 0, INTEGER: 1, "Enumeration": 1, REAL: 2}
_MISSING = "is no variable of it"
_LARGEST_INTEGER = 2**31 - 1
"""Of FMI 2.0, which has 32 bits."""


@dataclass(frozen=True)
class DriveMap:
    """Which FMU is the drive."""

    file: Path  # the FMU
    variables: Mapping[str, str] = field(default_factory=dict)  # its names by those of the messages, where they differ
    start: Mapping[str, Any] = field(default_factory=dict)  # values that it begins with, by its names
    scales: Mapping[str, float] = field(default_factory=dict)  # its values over those of the messages, both in SI units


def program(node: str, file: str) -> list[str]:
    """Return module and arguments that run the drive in a `file` in the place of a `node`.

    Raises ParameterError where it cannot stand there, CommandError where fmpy is missing or the FMU cannot be used.
    """
    if node != WINCH:
        raise ParameterError(f"--replace {node}=fmu:{file}: NODE must be {WINCH}")
    if find_spec("fmpy") is None:
        raise CommandError(f"--replace {node}=fmu:{file}: needs the package fmpy; {how_to_install('fmu')}")
    path = Path(file).resolve()
    drive_names(read_drive(path))
    return [NODE, str(path)]


def read_drive(path: Path) -> DriveMap:
    """Return the drive that an FMU file, or a map of one, at a `path` is.

    A map is YAML: `fmu`, a file beside it; `variables`, names of the FMU by those of the messages; `start`, values by
    the FMU's names. Raises ParameterError, in one line, for anything else.
    """
    if not path.is_file():
        raise ParameterError(f"{path}: no such file")
    if path.suffix == FMU:
        return DriveMap(path)
    if path.suffix != MAP:
        raise ParameterError(f"{path}: must be an FMU ({FMU}), or a map that names one ({MAP})")
    try:
        content = parse_yaml(path.read_bytes())
    except (OSError, YamlError) as error:
        raise ParameterError(f"{path}: {error}") from error
    if not isinstance(content, dict) or not isinstance(content.get("fmu"), str) or set(content) - set(_KEYS):
        raise ParameterError(f"{path}: must hold `fmu: FILE`, and may hold {' and '.join(_KEYS[1:])}")
    variables, start = content.get("variables") or {}, content.get("start") or {}
    if not isinstance(variables, dict) or not isinstance(start, dict):
        raise ParameterError(f"{path}: variables and start must be names with what belongs to each")
    known = [variable.name for port in _ports() for variable in port.variables]
    names, scales = {}, {}
    for name, entry in variables.items():
        given = entry if isinstance(entry, dict) else {"name": entry}
        own, scale = given.get("name"), given.get("scale", 1.0)
        is_scale = isinstance(scale, int | float) and not isinstance(scale, bool) and math.isfinite(scale) and scale
        if name not in known or not isinstance(own, str) or not is_scale or set(given) - {"name", "scale"}:
            raise ParameterError(
                f"{path}: variables: {name}: must be one of {', '.join(known)}, with a name of the FMU, or "
                "{name: NAME, scale: FACTOR}"
            )
        names[name] = own
        if "scale" in given:
            scales[name] = float(scale)
    file = path.parent / content["fmu"]
    if not file.is_file():
        raise ParameterError(f"{path}: fmu: no such file: {file}")
    return DriveMap(file, names, start, scales)


def _ports() -> tuple[Port, Port, Port]:
    """Return the messages of a drive: commands and tension in, its state out."""
    return (
        Port(topics.WINCH_COMMAND, WINCH_COMMAND),
        Port(topics.CABLE_STATE, ("top_tension",)),
        Port(topics.WINCH_STATE, WINCH_STATE),
    )


def drive_names(drive: DriveMap) -> dict[str, OwnVariable]:
    """Return the names of the variables that a `drive` has, by those of the messages; none of its code runs.

    Raises FmuRefusedError, in one line, where the FMU cannot be used, lacks what a drive must have, or has no variable
    of a name in the map, or one of a kind or unit that does not take the value.
    """
    with tempfile.TemporaryDirectory(prefix="heave-fmu-") as folder:
        unpack_fmu(drive.file, Path(folder))
        description = described(drive.file, Path(folder))
    has = {one.name: one for one in description.modelVariables}
    found, faults = {}, {}
    for name, value in drive.start.items():
        faults["start", name] = _start_fault(has[name].type, value) if name in has else _MISSING
    for name, own in drive.variables.items():
        faults[f"variables: {name}", own] = "" if own in has else _MISSING
    for port in _ports():
        for variable in port.variables:
            own = drive.variables.get(variable.name, variable.name)
            if own in has:
                conversion, fault = conversion_of(variable.unit, has[own], description.unitDefinitions)
                found[variable.name] = OwnVariable(own, conversion, drive.scales.get(variable.name, 1.0))
                misfit = _misfit(variable, has[own], is_out=port.topic == topics.WINCH_STATE)
                faults[variable.name, own] = misfit or fault
    for (place, own), fault in faults.items():
        if fault:
            raise FmuRefusedError(f"{drive.file}: {place}: {own} {fault}")
    for needed in (_SET_POINTS, _PAYOUTS):
        if not set(needed) & set(found):
            raise FmuRefusedError(f"{drive.file}: a drive needs the variable {' or '.join(needed)}, or a map of names")
    return found


def _start_fault(kind: str, value: object) -> str:
    """Return what a variable of a `kind` has against a start `value`; "": nothing."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    takes = {
        "Real": is_number and math.isfinite(value),  # type: ignore[arg-type]
        "Boolean": isinstance(value, bool),
        "String": isinstance(value, str),
    }.get(kind, isinstance(value, int) and is_number and abs(value) <= _LARGEST_INTEGER)
    return "" if takes else f"is {kind}, and takes no {value!r}"


def _misfit(field_: Variable, own: Any, *, is_out: bool) -> str:
    """Return why a variable of an FMU cannot be that of a message's field; "": it can.

    A number may go where a wider one has room; a flag is read from any number.

    Parameters
    ----------
    field_ : of the message
    own : FMPy's description of the variable
    is_out : the FMU gives it
    """
    if own.causality == ("input" if is_out else "output"):
        return f"is an {own.causality}, and this is what the drive {'gives' if is_out else 'takes'}"
    source, target = (own.type, field_.kind) if is_out else (field_.kind, own.type)
    if source in _WIDTHS and target in _WIDTHS:
        fits = _WIDTHS[source] <= _WIDTHS[target] or (is_out and target == BOOLEAN)
    else:
        fits = source == target
    return "" if fits else f"is {own.type}, and the message has {field_.kind}"


class FmuWinch:
    """A drive, stepped tick by tick as `VirtualWinch` is.

    Parameters
    ----------
    drive : the FMU
    tick_period : [s]

    Raises CommandError, in one line, where the FMU cannot be used or lacks what a drive must have.
    """

    def __init__(self, drive: DriveMap, *, tick_period: float) -> None:
        self._dt = tick_period
        self._commands, self._tensions, self._states = _ports()
        self._names = drive_names(drive)
        self._fmu = FmuInstance(drive.file, "virtual_winch", drive.start)
        try:
            self._fmu.steps_in(tick_period)
        except CommandError:
            self._fmu.close()
            raise
        self._forget()

    def _forget(self) -> None:
        self._command = WinchCommand(0, brake=True)
        self._tension = math.nan
        self._payout = 0.0
        self._commands.restart()
        self._tensions.restart()

    def restart(self) -> None:
        """Begin again at the first tick. Raises CommandError where the FMU cannot."""
        self._fmu.restart()
        self._forget()

    def step(self, tick: int, command: WinchCommand | None, tension: float | None) -> WinchState:
        """Do a tick and return the state at its end.

        Parameters
        ----------
        tick : its number, from 1
        command : that came for it; None: none
        tension : at the drum, that came for it [N]; None: none

        Raises CommandError where the FMU cannot go on, or its payout is no finite number.
        """
        now = round(tick * self._dt * 1e9)
        if command is not None:
            self._command = command
            self._commands.publish([WireReading(now, tuple(command))])
        if tension is not None:
            self._tension = tension
            self._tensions.publish([WireReading(now, (tension,))])
        for port in (self._commands, self._tensions):
            for variable, value in zip(port.variables, port.values, strict=True):
                if own := self._names.get(variable.name):
                    self._fmu.set(own.name, own.of_message(value))
        self._fmu.step((tick - 1) * self._dt, self._dt)
        state = self._filled({name: self._read(name) for name in WINCH_STATE if self._name(name) in self._names})
        self._payout = state["encoder_payout"]
        return WinchState(time=(tick + 1) * self._dt, **state)

    def close(self) -> None:
        """Free the FMU."""
        self._fmu.close()

    def _name(self, field_name: str) -> str:
        return f"winch.state.{field_name}"

    def _read(self, field_name: str) -> Any:
        own = self._names[self._name(field_name)]
        value = own.to_message(self._fmu.get(own.name))
        return bool(value) if field_name == "brake" else value

    def _filled(self, known: dict[str, Any]) -> dict[str, Any]:
        """Return the whole state of a drive of which some fields are `known`."""
        encoder = known.get("encoder_payout", known.get("payout", math.nan))
        if not math.isfinite(encoder):
            raise CommandError(f"{self._fmu.file}: its payout is {encoder}, which is no place of a drum")
        rate = known.get("payout_rate", (encoder - self._payout) / self._dt)
        filled = {
            "command_sequence": self._command.sequence,
            "payout": math.nan,
            "payout_rate": rate,
            "payout_acceleration": math.nan,
            "encoder_payout": encoder,
            "encoder_payout_rate": rate,
            "tension": self._tension,
            "power": -self._tension * rate,
            "limits_hit": 0,
            "brake": self._command.brake,
            "fault": 0,
            "release": 0,
        }
        return filled | known
