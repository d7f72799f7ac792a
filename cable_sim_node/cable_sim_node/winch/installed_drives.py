"""Drives that extras bring, by entry point: what a winch can be driven by beside the ideal servo."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import cache
from typing import Any, NamedTuple, TypeVar

from heave_node.extras import MissingExtraError, extra_parts, load_part, missing_extra
from heave_node.parameters import group

T = TypeVar("T")

GROUP = "heave.drives"
"""Group of entry points that are drives: a `DriveEntry` each, by the name that `drive` chooses it by."""
SERVO = "speed_servo"
"""The ideal servo, which is always there."""
EXTRA_OF = dict.fromkeys(("electric", "pump_controlled", "valve_controlled"), "drives")
"""The extra that brings each drive, so that one that is not installed can be named."""


class DriveEntry(NamedTuple):
    """A drive that an extra brings."""

    parameters: type  # its parameter set, a group of the winch's under the name of the drive
    # makes it, a `Drive` (`cable_sim_node.winch.drives.interface`), from the winch's parameters, its own, and the
    # tension [N] under which it is at rest; raises ValueError where it cannot hold that
    make: Callable[[Any, Any, float], Any]
    # refuses by ValueError what does not fit together: the winch's parameters, and its own
    check: Callable[[Any, Any], None]


@cache
def installed_drives() -> dict[str, DriveEntry]:
    """Return the drives that are installed, by name, without the servo."""
    found = {}
    for name in dict.fromkeys((*EXTRA_OF, *extra_parts(GROUP))):
        with suppress(MissingExtraError):
            found[name] = load_part(GROUP, name, name, EXTRA_OF.get(name, name))
    return found


def absent_drives() -> tuple[str, ...]:
    """Return the names of known drives that are not installed."""
    return tuple(name for name in EXTRA_OF if name not in installed_drives())


def check_is_installed(drive: str) -> None:
    """Refuse a known `drive` whose extra is missing, by ValueError with what it needs."""
    if drive in absent_drives():
        raise ValueError(str(missing_extra(f"drive = {drive}", EXTRA_OF[drive])))


def with_drives(kind: type[T]) -> type[T]:
    """Let the dataclass that `kind` becomes have the parameters of each installed drive, as a group of its name."""
    for name, entry in installed_drives().items():
        kind.__annotations__[name] = entry.parameters
        setattr(kind, name, group(entry.parameters))
    return kind
