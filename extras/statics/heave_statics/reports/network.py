"""Several cables to one load, or a net of them, from a file: where the free points come to rest, what each cable pulls.

The file names points and cables; `boom_tip`, `unit` and the scenario's rope are known to it:

    points:
      stern: {at: [-30, 8, 5]}                       # held there, z up [m]
      bridle: {force: [0, 0, -2000], drag_area: 0.5} # free, with a force [N] and C_D S [m2] of its own
    cables:
      lift: {from: unit, to: boom_tip}               # without a length: the scenario's rope with all that is on it
      umbilical: {from: unit, to: stern, length: 340, catalogue: NAME, diameter: 0.03}   # and other cable.* parameters
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from cable_sim_node.errors import StaticsError
from cable_sim_node.parameters import CableSimParameters, ClumpsParameters, SectionsParameters
from cable_sim_node.physics.current import current_of
from heave_node.catalogue import entries
from heave_node.files.bounded_yaml import parse_yaml
from heave_node.files.given_files import read_given
from heave_node.parameters import ParameterError, build_parameters, flatten
from heave_node.sheet import Column, Sheet

from heave_statics.network import NetworkCable, NetworkPoint, NetworkShape, solve_network
from heave_statics.reports.cases import CasesReport
from heave_statics.shape import StaticShape
from heave_statics.suspended import Rope, shapes_at_rest, unit_load
from heave_statics.system import PointLoad, StaticCable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

UNIT, BOOM_TIP = "unit", "boom_tip"
POINT, CABLE = {"at", "force", "drag_area"}, {"from", "to", "length", "catalogue"}


@dataclass(frozen=True)
class NetworkLine:
    """A cable of the network at rest."""

    name: str  # of it
    start: str  # point at its end s = 0
    end: str  # point at its end s = L
    shape: StaticShape  # of it


CABLES = Sheet(
    Column("cable", "name", "name"),
    Column("from", "start", "from"),
    Column("to", "end", "to"),
    Column("length m", "shape.cable.length", "length_m", ".2f"),
    Column("stretched m", "shape.stretched_length", "stretched_length_m", ".2f"),
    Column("at from kN", lambda one: float(np.linalg.norm(one.shape.lower[0])), "from_tension_n", ".3f", 1e-3),
    Column("at to kN", "shape.top_tension", "to_tension_n", ".3f", 1e-3),
    Column("smallest kN", lambda one: float(one.shape.tension.min()), "least_tension_n", ".3f", 1e-3),
)
"""Columns of the cables."""


def network_report(parameters: CableSimParameters, path: Path, boom_tip: tuple[float, float, float]) -> CasesReport:
    """Return the equilibrium of the network in a file; rows are `NetworkLine`.

    Parameters
    ----------
    parameters : of the plant: its rope and unit, its water and current
    path : of the file
    boom_tip : position [m], z up

    There is no seabed to lie on, and the unit is under water. A cable that is partly in air is there at its `to`.

    Raises
    ------
    ParameterError
        for a file that names something unknown.
    StaticsError, NoEquilibriumError
        as `solve_network` and `shapes_at_rest`.
    """
    given = parse_yaml(read_given(path)) or {}
    points = {BOOM_TIP: NetworkPoint(boom_tip), UNIT: NetworkPoint(None, unit_load(parameters))}
    points |= {name: _point(parameters, values, f"{path}: {name}") for name, values in _named(given, "points", path)}
    cables = dict(_named(given, "cables", path))
    ropes = [Rope(_rope(parameters, values, f"{path}: {name}"), PointLoad(0.0)) for name, values in cables.items()]
    ends = [(str(values.get("from")), str(values.get("to"))) for values in cables.values()]
    used = {name: point for name, point in points.items() if name in given["points"] or name in sum(ends, ())}
    found: list[NetworkShape] = []

    def solve(made: list[StaticCable]) -> tuple[StaticShape, ...]:
        network = [NetworkCable(*pair, cable) for pair, cable in zip(ends, made, strict=True)]
        found[:] = [solve_network(used, network, current_of(parameters))]
        return found[0].shapes

    shapes = shapes_at_rest(ropes, solve)
    lines = tuple(NetworkLine(name, *pair, one) for name, pair, one in zip(cables, ends, shapes, strict=True))
    for line in lines:
        if line.shape.positions[0, 2] > 0.0 > line.shape.positions[-1, 2] and parameters.surface:
            raise StaticsError(f"{path}: {line.name}: its end in air must be its `to`")
    places = found[0].places
    at_tip = [shape.top_tension for shape, pair in zip(shapes, ends, strict=True) if pair[1] == BOOM_TIP]
    at_unit = [float(np.linalg.norm(one.lower[0])) for one, pair in zip(shapes, ends, strict=True) if pair[0] == UNIT]
    return CasesReport(
        *(CABLES, "cables", lines, {"points_m": {name: place.tolist() for name, place in places.items()}}),
        largest_tension=max(at_tip, default=float("nan")),
        side=partial(_draw, lines, places, 2, "from the side"),
        other=partial(_draw, lines, places, 1, "from above"),
        unit_load=max(at_unit, default=float("nan")),
        notes=("", *(f"{name}: {x:.3f}, {y:.3f}, {z:.3f} m" for name, (x, y, z) in places.items())),
    )


def _named(given: Any, key: str, path: Path) -> list[tuple[str, Mapping[str, Any]]]:
    """Return the entries of a table of the file by name; raise ParameterError for another form."""
    table = given.get(key) if isinstance(given, Mapping) else None
    if not isinstance(table, Mapping) or not all(isinstance(one, Mapping) for one in table.values()):
        raise ParameterError(f"{path}: must have the tables points and cables, each of names with their values")
    return [(str(name), values) for name, values in table.items()]


def _point(parameters: CableSimParameters, values: Mapping[str, Any], where: str) -> NetworkPoint:
    if set(values) - POINT or ("at" in values and len(values) > 1):
        raise ParameterError(f"{where}: a point has at, or force [N] and drag_area [m2]; got {', '.join(values)}")
    if "at" in values:
        return NetworkPoint(_triple(values["at"], f"{where}: at"))
    force = _triple(values.get("force", (0.0, 0.0, 0.0)), f"{where}: force")
    drag = 0.5 * parameters.water_density * _number(values.get("drag_area", 0.0), f"{where}: drag_area", least=0.0)
    return NetworkPoint(None, PointLoad(0.0, force, body_drag=drag))


def _triple(value: Any, where: str) -> tuple[float, float, float]:
    if not isinstance(value, Sequence) or len(value) != 3:
        raise ParameterError(f"{where}: must be three numbers; got {value!r}")
    x, y, z = (_number(one, where) for one in value)
    return x, y, z


def _number(value: Any, where: str, least: float = -math.inf) -> float:
    """Return a finite number of the file, not below the `least`; raise ParameterError for anything else."""
    with suppress(TypeError, ValueError):
        number = float(value)
        if math.isfinite(number) and number >= least:
            return number
    wanted = "a finite number" if math.isinf(least) else f"a finite number from {least:g} up"
    raise ParameterError(f"{where}: must be {wanted}; got {value!r}")


def _rope(parameters: CableSimParameters, values: Mapping[str, Any], where: str) -> CableSimParameters:
    """Return the plant whose main cable is the one of these values: the scenario's, or one of its own length."""
    own = {name: value for name, value in values.items() if name not in CABLE}
    if "from" not in values or "to" not in values:
        raise ParameterError(f"{where}: a cable needs from and to")
    if "length" not in values:
        if own or "catalogue" in values:
            raise ParameterError(f"{where}: a cable of its own needs its length")
        return parameters
    known = entries("cable")
    if values.get("catalogue", "") not in ("", *known):
        raise ParameterError(f"{where}: no cable {values['catalogue']} in the catalogue")
    base = known[values["catalogue"]].values if "catalogue" in values else flatten(parameters.cable)
    cable = build_parameters(type(parameters.cable), {**base, **own}, where=where)
    return replace(
        parameters,
        cable=cable,
        length=_number(values["length"], f"{where}: length", least=0.0),
        sections=SectionsParameters(),
        clumps=ClumpsParameters(),
    )


def _draw(lines: tuple[NetworkLine, ...], places: Mapping[str, Any], up: int, title: str, axis: Axes) -> None:
    """Draw the network over x, with the coordinate `up`, into an `axis` with a `title`."""
    for line in lines:
        curve = line.shape.curve()
        axis.plot(curve[:, 0], curve[:, up], label=line.name)
    for name, place in places.items():
        axis.plot(place[0], place[up], "ko", markersize=3.0)
        axis.annotate(name, (place[0], place[up]), fontsize="small")
    axis.set(xlabel="x [m]", ylabel=f"{'xyz'[up]} [m]", title=title)
    if up == 2:
        axis.axhline(0.0, color="tab:blue", linewidth=0.8, alpha=0.5)
        axis.legend(fontsize="small")
