"""Drives that extras bring, by entry point: what a winch can be driven by beside the ideal servo."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import make_dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from heave_node.extras import PARTS, MissingExtraError, extra_of, known_parts, load_part, missing_extra
from heave_node.parameters import group

GROUP = "heave.drives"
"""Group of entry points that are drives: a `DriveEntry` each, by the name that `drive` chooses it by."""
SERVO = "speed_servo"
"""The ideal servo, which is always there."""


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
    for name in known_parts(GROUP):
        with suppress(MissingExtraError):
            found[name] = load_part(GROUP, name, name)
    return found


def absent_drives() -> tuple[str, ...]:
    """Return the names of known drives that are not installed."""
    return tuple(name for name in PARTS[GROUP] if name not in installed_drives())


def check_is_installed(drive: str) -> None:
    """Refuse a known `drive` whose extra is missing, by ValueError with what it needs."""
    if drive in absent_drives():
        raise ValueError(str(missing_extra(f"drive = {drive}", extra_of(GROUP, drive))))


def drive_groups(installed: Mapping[str, DriveEntry]) -> type:
    """Return a dataclass with the parameters of each `installed` drive as a group of its name."""
    fields: list[tuple[str, type, Any]] = [
        (name, entry.parameters, group(entry.parameters)) for name, entry in installed.items()
    ]
    return make_dataclass("DriveGroups", fields, frozen=True)


if TYPE_CHECKING:

    class DriveGroups:
        """Groups of the drives that are installed; only a drive itself reads its own."""

else:
    DriveGroups = drive_groups(installed_drives())
