"""The words under `system.`: what the simulated ship and the controller's belief share, each under one name.

A scenario says once, under `/**`, what the cable, the unit, the winch, the sea and the vessel are. Every node receives
these values and takes those that it has a parameter for, under its own name: `system.sea.peak_period` is `peak_period`
of `wave_vessel` and `sea.peak_period` of `winch_controller`. A value in a node's own section wins: that is how a
belief is made wrong on purpose.

>>> own = ("sea.peak_period", "factor")
>>> system_names("winch_controller", own)
{'system.sea.peak_period': 'sea.peak_period'}
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

from heave_node.catalogue import with_entries
from heave_node.parameters import Given, unknown_parameter

SYSTEM = "system."
"""Prefix of the shared names."""

_WINCH = (
    *("law", "time_constant", "position_gain", "position_rate", "command_delay"),
    *("speed_limit", "acceleration_limit", "payout_minimum", "payout_maximum", "power_limit"),
    *("speed_gain", "creep"),
)
_SEA = (
    *("spectrum", "significant_wave_height", "peak_period", "peak_enhancement", "shape", "direction"),
    *("spectrum_file", "spectrum_time"),
)
_CRANE = ("boom_length", "jib_length", "offset", "slew", "luff", "knuckle", "extension")
_COURSE = ("heading", "speed")
_MRU = ("noise", "rate_noise", "high_pass_period", "latency")
_SENSORS = (
    *(f"{sensor}.{what}" for sensor in ("depth", "velocity", "load_cell") for what in ("noise", "rate", "latency")),
    *("imu.rate", "imu.latency"),
)


@dataclass(frozen=True)
class Shared:
    """A word of the system: one parameter, or a whole group where it ends with a point."""

    word: str  # name after `system.`
    own: Mapping[str, str]  # what each node calls it; the first node owns the word: it has every parameter of the group

    @property
    def owner(self) -> str:
        """Node that refuses an unknown name."""
        return next(iter(self.own))

    def covers(self, word: str) -> bool:
        """Return whether a name after `system.` is this word, or belongs to this group."""
        return word.startswith(self.word) if self.word.endswith(".") else word == self.word


def _shared(word: str, **own: str) -> Shared:
    if "winch_controller" in own:  # where its envelope stands alone it has the same groups by the same names
        own["winch_envelope"] = own["winch_controller"]
    return Shared(word, own)


SHARED: tuple[Shared, ...] = (
    _shared("length", cable_sim="length", winch_controller="length"),
    _shared("water_density", cable_sim="water_density", winch_controller="water_density"),
    _shared("gravity", cable_sim="gravity", winch_controller="gravity"),
    _shared("accept_implausible", wave_vessel="accept_implausible", winch_controller="vessel.accept_implausible"),
    _shared("boom_tip_height", **dict.fromkeys(("wave_vessel", "cable_sim", "winch_controller"), "boom_tip_height")),
    _shared("cable.", cable_sim="cable.", winch_controller="cable."),
    _shared("linear.inertia", cable_sim="linear.inertia", winch_controller="cable_model.inertia"),
    _shared("linear.damping", cable_sim="linear.damping", winch_controller="cable_model.damping"),
    _shared("unit.", cable_sim="unit.", winch_controller="unit."),
    *(_shared(f"winch.{name}", virtual_winch=name, winch_controller=f"winch.{name}") for name in _WINCH),
    _shared("winch.rated_pull", virtual_winch="rated_pull"),
    *(_shared(f"sea.{name}", wave_vessel=name, winch_controller=f"sea.{name}") for name in _SEA),
    _shared("sea.swell.", wave_vessel="swell.", winch_controller="sea.swell."),
    _shared("sea.spreading.", wave_vessel="spreading.", winch_controller="sea.spreading."),
    _shared("sea.filter_form", wave_vessel="filter.form", winch_controller="sea.filter_form"),
    _shared("sea.filter_states", wave_vessel="filter.states", winch_controller="sea.filter_states"),
    _shared("vessel.", wave_vessel="vessel.", winch_controller="vessel."),
    *(_shared(f"crane.{name}", wave_vessel=f"crane.{name}", winch_controller=f"crane.{name}") for name in _CRANE),
    *(_shared(f"course.{name}", wave_vessel=f"course.{name}", winch_controller=f"vessel.{name}") for name in _COURSE),
    *(
        _shared(f"sensors.mru.{name}", wave_vessel=f"mru.{name}", winch_controller=f"sensors.mru.{name}")
        for name in _MRU
    ),
    *(_shared(f"sensors.{one}", cable_sim=f"sensors.{one}", winch_controller=f"sensors.{one}") for one in _SENSORS),
)
"""The one table of shared names."""


def system_names(node: str, own_names: Collection[str]) -> dict[str, str]:
    """Return the shared names that a node takes, each with the node's own name for it.

    Parameters
    ----------
    node : name of the node
    own_names : dotted names of its parameters
    """
    return dict(_names_of(node, tuple(own_names))[0])


@lru_cache(maxsize=256)
def _names_of(node: str, own_names: tuple[str, ...]) -> tuple[Mapping[str, str], Mapping[str, str]]:
    """Return the shared names that a node takes, and of these those that it owns, each with the node's own name."""
    names: dict[str, str] = {}
    single = _single_names(node)
    for shared in (shared for shared in SHARED if node in shared.own):
        mine = shared.own[node]
        for name in own_names:
            if name == mine or (mine.endswith(".") and name.startswith(mine) and name not in single):
                names[f"{SYSTEM}{shared.word}{name.removeprefix(mine)}"] = name
    words = tuple(shared for shared in SHARED if shared.owner == node)
    owned = {name for name in names if any(shared.covers(name.removeprefix(SYSTEM)) for shared in words)}
    return names, {name: own for name, own in names.items() if name in owned}


@lru_cache(maxsize=64)
def _single_names(node: str) -> frozenset[str]:
    """Return a node's own names that have a word to themselves: no group around them has another for them."""
    return frozenset(shared.own[node] for shared in SHARED if node in shared.own and not shared.own[node].endswith("."))


def own_name(node: str, name: str) -> str:
    """Return a node's own name for a shared one; "" where it takes none.

    Parameters
    ----------
    node : name of the node
    name : with `system.`
    """
    word = name.removeprefix(SYSTEM) if name.startswith(SYSTEM) else ""
    for shared in SHARED:
        if node in shared.own and shared.covers(word):
            mine = shared.own[node] + word.removeprefix(shared.word)
            if not shared.word.endswith(".") or mine not in _single_names(node):
                return mine
    return ""


def owned_names(node: str, own_names: Collection[str]) -> dict[str, str]:
    """Return those of `system_names` that the `node` owns; `own_names` are those of its parameters."""
    return dict(_names_of(node, tuple(own_names))[1])


def take_system(node: str, own_names: Collection[str], given: Mapping[str, Given]) -> dict[str, Given]:
    """Return the values of one node by its own names: its own ones, and the shared ones that it has a parameter for.

    Parameters
    ----------
    node : name of the node
    own_names : dotted names of its parameters
    given : what it was given, shared names among them

    Raises
    ------
    ParameterError
        For a shared name that no node knows, or that this node should know as its owner, and for one that is not in
        the catalogue.
    """
    names = system_names(node, own_names)
    own = {name: value for name, value in given.items() if not name.startswith(SYSTEM)}
    for name, value in with_entries(given).items():
        if not name.startswith(SYSTEM):
            continue
        if name in names:
            own.setdefault(names[name], replace(value, reader=node))
        elif _is_unknown(name, to=node if names else ""):
            raise unknown_parameter(value, {*names, *(SYSTEM + shared.word for shared in SHARED)})
    return own


def _is_unknown(name: str, *, to: str) -> bool:
    """Return whether a shared name that a node has no parameter for is a mistake, or another node's business.

    A node that takes no shared name at all owns none, whatever it is called: a bag that is played in the place of
    `wave_vessel`, for one.
    """
    owners = {shared.owner for shared in SHARED if shared.covers(name.removeprefix(SYSTEM))}
    return not owners or to in owners
