"""What RViz and Foxglove show of the plant: cable, unit, boom tip, sea surface and seabed."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from heave_node.cdr.packer import Packer
from heave_node.interface import topics
from heave_node.numerics.arrays import Array
from visualization_msgs.msg import Marker

from cable_sim_node.component import PlantState
from cable_sim_node.conversions import WORLD
from cable_sim_node.parameters import SeabedParameters
from cable_sim_node.physics.seabed import Seabed

NAMESPACE = "plant"
PROFILE_PLACES = 101
"""Number of points of a seabed's profile that are shown."""
Color = tuple[float, float, float, float]
"""Red, green, blue and opacity, each 0 to 1."""
TAUT, SLACK = (1.0, 0.8, 0.1, 1.0), (0.9, 0.1, 0.1, 1.0)
YELLOW, GREY = (1.0, 0.6, 0.0, 1.0), (0.6, 0.6, 0.6, 0.5)
SEA, BED = (0.1, 0.4, 0.8, 0.3), (0.5, 0.4, 0.3, 0.8)
_NONE: Array = np.zeros((0, 4))
_MARKERS = Packer(topics.MARKERS.type, ("markers",))


def plant_markers(state: PlantState, seabed: SeabedParameters, stamp: int) -> bytes:
    """Return the markers, a serialised visualization_msgs/MarkerArray: the cable (a segment without tension is red),
    unit, shadow unit, boom tip, sea, seabed.

    Parameters
    ----------
    state : of the plant
    seabed : its parameters; none is shown without a depth
    stamp : of all markers [ns]
    """
    length = max(float(state.unstretched_length), 1.0)
    size, half = max(0.01 * length, 0.5), 0.5 * length
    shapes = [
        _cable(state, width=0.2 * size),
        _body(Marker.CUBE, state.unit.position, size, YELLOW),
        _body(Marker.CUBE, state.uncompensated.position, size, GREY),
        _body(Marker.SPHERE, state.node_positions[-1], 0.5 * size, YELLOW),
        _ground(lambda _: 0.0, np.array([-half, half]), (1.0, 0.0), SEA),
    ]
    if seabed.depth > 0.0:
        bottom, points, tip = Seabed(seabed), seabed.profile.distance, float(state.node_positions[-1, 2])
        places = np.linspace(min(-half, points[0]), max(half, points[-1]), PROFILE_PLACES) if points else (-half, half)
        shapes.append(_ground(partial(bottom.height, boom_tip=tip), np.array(places), bottom.direction, BED))
    header = (stamp, WORLD)
    return _MARKERS.pack([(header, NAMESPACE, number, *shape) for number, shape in enumerate(shapes)])


def _shape(
    kind: int, place: Array, scale: tuple[float, ...], color: Color, points: Array = _NONE, colors: Array = _NONE
) -> tuple[Any, ...]:
    """Return the fields of a visualization_msgs/Marker from its type on, in their order: from its texture on empty."""
    pose = (*place.tolist(), 0.0, 0.0, 0.0, 1.0)
    return (
        kind,
        Marker.ADD,
        pose,
        scale,
        color,
        0,
        False,
        points,
        colors,
        "",
        ((0, ""), "", ()),
        (),
        "",
        "",
        ("", ()),
        False,
    )


def _cable(state: PlantState, *, width: float) -> tuple[Any, ...]:
    colors = np.where(state.segment_tensions[:, None] > 0.0, TAUT, SLACK)
    shown = np.vstack((colors, colors[-1:]))
    return _shape(Marker.LINE_STRIP, np.zeros(3), (width, 0.0, 0.0), TAUT, state.node_positions, shown)


def _body(kind: int, position: Array, size: float, color: Color) -> tuple[Any, ...]:
    return _shape(kind, position, (size, size, size), color)


def _ground(
    height: Callable[[tuple[float, float]], float], places: Array, along: tuple[float, float], color: Color
) -> tuple[Any, ...]:
    """Return a surface of strips, seen from both sides.

    Parameters
    ----------
    height : z of the surface at x, y [m]
    places : distances of the strips' edges from the origin [m]; the surface reaches to the first one on either side
    along : unit vector of these distances
    color : of the surface
    """
    half = abs(float(places[0]))

    def corner(s: float, side: float) -> tuple[float, float, float]:
        x, y = s * along[0] - side * along[1], s * along[1] + side * along[0]
        return x, y, height((x, y))

    points = []
    for start, end in itertools.pairwise(places.tolist()):
        corners = [corner(start, -half), corner(end, -half), corner(end, half), corner(start, half)]
        points += [corners[i] for i in (0, 1, 2, 0, 2, 3, 0, 2, 1, 0, 3, 2)]
    return _shape(Marker.TRIANGLE_LIST, np.zeros(3), (1.0, 1.0, 1.0), color, np.array(points))
