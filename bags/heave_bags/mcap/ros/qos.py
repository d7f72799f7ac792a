"""Quality of service as rosbag2 stores it: plain data with policies as words, no rclpy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import yaml
from heave_node.files.bounded_yaml import DUMPER, parse_yaml

INFINITE = 9_223_372_036_854_775_807
"""A duration that never ends [ns]."""

_SECOND = 1_000_000_000


@dataclass(frozen=True)
class OfferedQos:
    """See rmw_qos_profile_t, whose names these are: what a publisher offers.

    Durations in nanoseconds, INFINITE where none is requested.
    """

    history: str = "keep_last"
    depth: int = 10
    reliability: str = "reliable"
    durability: str = "volatile"
    deadline: int = INFINITE
    lifespan: int = INFINITE
    liveliness: str = "automatic"
    liveliness_lease_duration: int = INFINITE

    def to_mapping(self) -> dict[str, Any]:
        """Return the mapping that rosbag2 writes."""
        return {
            "history": self.history,
            "depth": self.depth,
            "reliability": self.reliability,
            "durability": self.durability,
            "deadline": _duration(self.deadline),
            "lifespan": _duration(self.lifespan),
            "liveliness": self.liveliness,
            "liveliness_lease_duration": _duration(self.liveliness_lease_duration),
            "avoid_ros_namespace_conventions": False,
        }


def _duration(nanoseconds: int) -> dict[str, int]:
    return {"sec": nanoseconds // _SECOND, "nsec": nanoseconds % _SECOND}


def _nanoseconds(value: Any) -> int:
    total = int(value["sec"]) * _SECOND + int(value["nsec"])
    return total if 0 < total < INFINITE else INFINITE


_WORDS = {
    "history": {1: "keep_last", 2: "keep_all"},
    "reliability": {1: "reliable", 2: "best_effort"},
    "durability": {1: "transient_local", 2: "volatile"},
    "liveliness": {1: "automatic", 3: "manual_by_topic"},
}
"""Older bags store policies as numbers of rmw."""


def from_mapping(values: Mapping[str, Any]) -> OfferedQos:
    """Read the profile `values` of a bag; a policy that is missing or not known takes the default."""
    default = OfferedQos()
    found: dict[str, Any] = {}
    for name, meanings in _WORDS.items():
        value = values.get(name)
        word = str(meanings.get(value) if isinstance(value, int) else value).lower()
        found[name] = word if word in meanings.values() else getattr(default, name)
    for name in ("deadline", "lifespan", "liveliness_lease_duration"):
        found[name] = _nanoseconds(values[name]) if name in values else INFINITE
    depth = int(values.get("depth", default.depth))
    return OfferedQos(depth=depth if depth > 0 else default.depth, **found)


def to_yaml(profiles: list[OfferedQos] | tuple[OfferedQos, ...]) -> str:
    """Return profiles as the YAML text of a channel's metadata."""
    return str(yaml.dump([profile.to_mapping() for profile in profiles], Dumper=DUMPER, sort_keys=False))


UNREADABLE = (TypeError, LookupError, ValueError, ArithmeticError, AttributeError)
"""Errors that reading the YAML text of anyone raises."""


def from_yaml(text: str) -> tuple[OfferedQos, ...]:
    """Read the YAML text of a channel's metadata; an empty one gives no profiles. Raises one of UNREADABLE."""
    return tuple(from_mapping(values) for values in parse_yaml(text) or [])
