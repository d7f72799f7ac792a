"""What RViz and Foxglove show of the plant: cable, unit, boom tip, sea surface and seabed."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import partial

import numpy as np
from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Point, Vector3
from heave_node.numerics.arrays import Array
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from cable_sim_node.component import PlantState
from cable_sim_node.conversions import WORLD
from cable_sim_node.parameters import SeabedParameters
from cable_sim_node.physics.seabed import Seabed

NAMESPACE = "plant"
PROFILE_PLACES = 101
"""Number of points of a seabed's profile that are shown."""
TAUT = ColorRGBA(r=1.0, g=0.8, b=0.1, a=1.0)
SLACK = ColorRGBA(r=0.9, g=0.1, b=0.1, a=1.0)
YELLOW = ColorRGBA(r=1.0, g=0.6, b=0.0, a=1.0)
GREY = ColorRGBA(r=0.6, g=0.6, b=0.6, a=0.5)
SEA = ColorRGBA(r=0.1, g=0.4, b=0.8, a=0.3)
BED = ColorRGBA(r=0.5, g=0.4, b=0.3, a=0.8)


def plant_markers(state: PlantState, seabed: SeabedParameters, stamp: Time) -> MarkerArray:
    """Return the markers: the cable (a segment without tension is red), unit, shadow unit, boom tip, sea, seabed.

    Parameters
    ----------
    state : of the plant
    seabed : its parameters; none is shown without a depth
    stamp : of all markers
    """
    length = max(float(state.unstretched_length), 1.0)
    size, half = max(0.01 * length, 0.5), 0.5 * length
    markers = [
        _cable(state, stamp, width=0.2 * size),
        _body(1, Marker.CUBE, state.unit.position, size, YELLOW, stamp),
        _body(2, Marker.CUBE, state.uncompensated.position, size, GREY, stamp),
        _body(3, Marker.SPHERE, state.node_positions[-1], 0.5 * size, YELLOW, stamp),
        _ground(4, lambda _: 0.0, np.array([-half, half]), (1.0, 0.0), SEA, stamp),
    ]
    if seabed.depth > 0.0:
        bottom, points, tip = Seabed(seabed), seabed.profile.distance, float(state.node_positions[-1, 2])
        places = np.linspace(min(-half, points[0]), max(half, points[-1]), PROFILE_PLACES) if points else (-half, half)
        markers.append(_ground(5, partial(bottom.height, boom_tip=tip), np.array(places), bottom.direction, BED, stamp))
    return MarkerArray(markers=markers)


def _marker(identifier: int, kind: int, stamp: Time) -> Marker:
    marker = Marker(
        header=Header(stamp=stamp, frame_id=WORLD), ns=NAMESPACE, id=identifier, type=kind, action=Marker.ADD
    )
    marker.pose.orientation.w = 1.0
    marker.lifetime = Duration()
    return marker


def _cable(state: PlantState, stamp: Time, *, width: float) -> Marker:
    marker = _marker(0, Marker.LINE_STRIP, stamp)
    marker.scale.x = width
    marker.points = [_point(position) for position in state.node_positions]
    colors = [TAUT if tension > 0.0 else SLACK for tension in state.segment_tensions]
    marker.colors = [*colors, colors[-1]]
    marker.color = TAUT
    return marker


def _body(identifier: int, kind: int, position: Array, size: float, color: ColorRGBA, stamp: Time) -> Marker:
    marker = _marker(identifier, kind, stamp)
    marker.pose.position = _point(position)
    marker.scale = Vector3(x=size, y=size, z=size)
    marker.color = color
    return marker


def _point(position: Array) -> Point:
    return Point(x=float(position[0]), y=float(position[1]), z=float(position[2]))


def _ground(
    identifier: int,
    height: Callable[[tuple[float, float]], float],
    places: Array,
    along: tuple[float, float],
    color: ColorRGBA,
    stamp: Time,
) -> Marker:
    """Return a surface of strips, seen from both sides.

    Parameters
    ----------
    identifier : of the marker
    height : z of the surface at x, y [m]
    places : distances of the strips' edges from the origin [m]; the surface reaches to the first one on either side
    along : unit vector of these distances
    color, stamp : of the marker
    """
    marker = _marker(identifier, Marker.TRIANGLE_LIST, stamp)
    marker.scale = Vector3(x=1.0, y=1.0, z=1.0)
    half = abs(float(places[0]))

    def corner(s: float, side: float) -> Point:
        x, y = s * along[0] - side * along[1], s * along[1] + side * along[0]
        return Point(x=x, y=y, z=height((x, y)))

    for start, end in itertools.pairwise(places.tolist()):
        corners = [corner(start, -half), corner(end, -half), corner(end, half), corner(start, half)]
        marker.points += [corners[i] for i in (0, 1, 2, 0, 2, 3, 0, 2, 1, 0, 3, 2)]
    marker.color = color
    return marker
