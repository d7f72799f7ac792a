"""The kinds of fault of simulated devices: one vocabulary for all of them.

A kind of device is "sensor" (on the unit or the cable), "mru" (the motion reference unit), "encoder" (of the drum) or
"winch". To add a fault, add its kind to FAULTS and let the devices that know it do it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class FaultKind:
    """A kind of fault."""

    meaning: str  # what happens from the start for the duration
    devices: tuple[str, ...]  # kinds of device that know it
    magnitude: str = ""  # what the magnitude is, with its unit; empty: not used
    own: Mapping[str, str] = field(default_factory=dict)  # what happens instead, by kind of device

    def of(self, device: str) -> str:
        """Return what happens to a kind of `device`."""
        return self.own.get(device, self.meaning)

    @property
    def words(self) -> str:
        """What happens, of all kinds of device."""
        return "; ".join([self.meaning, *(f"{device}: {words}" for device, words in self.own.items())])


_SENSORS = ("sensor", "mru")
_ALL = (*_SENSORS, "encoder", "winch")
PAYS_OUT = "speed at which the load pays out, at least 0 [m/s]"
"""Magnitude of the faults in which the drum gives way."""

FAULTS: dict[str, FaultKind] = {
    "freeze": FaultKind("repeats the values of the last sample, with fresh stamps", (*_SENSORS, "encoder")),
    "gap": FaultKind("no samples", (*_SENSORS, "winch"), own={"winch": "commands are lost"}),
    "spike": FaultKind(
        "only the first sample is offset, on all axes",
        (*_SENSORS, "encoder"),
        "error, in the sensor's unit",
        {"mru": "only the first sample is offset, in heave alone"},
    ),
    "jump": FaultKind(
        "every sample is offset, on all axes",
        (*_SENSORS, "encoder"),
        "error, in the sensor's unit",
        {"mru": "every sample is offset, in heave alone"},
    ),
    "scale": FaultKind(
        "every sample is multiplied, on all axes",
        (*_SENSORS, "encoder"),
        "factor, not 0: -1 for a reversed sensor",
        {"mru": "heave, its rate and acceleration are multiplied"},
    ),
    "nan": FaultKind("every sample is NaN", (*_SENSORS, "encoder")),
    "rate": FaultKind("samples are taken at a different rate", _SENSORS, "rate, above 0 [Hz]"),
    "delay": FaultKind(
        "samples arrive later, with their true stamp",
        (*_SENSORS, "winch"),
        "additional delay, at least 0 and for the mru at most 10 [s]",
        {"winch": "commands arrive later"},
    ),
    "jitter": FaultKind(
        "each sample arrives later by a random time, uniform, with its true stamp",
        (*_SENSORS, "winch"),
        "largest additional delay, at least 0 and for the mru at most 10 [s]",
        {"winch": "each command arrives later by a random time, uniform"},
    ),
    "restart": FaultKind("silent (0: for 2 s), then settling: its high-pass filter starts again", ("mru",)),
    "drive": FaultKind("the drive trips", ("winch",)),
    "emergency_stop": FaultKind("the emergency stop is pressed", ("winch",)),
    "reverse": FaultKind("the drum turns against the command", ("winch",)),
    "brake_slip": FaultKind("the engaged brake slips under load", ("winch",), PAYS_OUT),
    "brake_open": FaultKind("the brake is energised open: it does not engage", ("winch",), PAYS_OUT),
    "brake_shut": FaultKind("the brake does not open", ("winch",)),
    "creep": FaultKind("the drum creeps under load besides what it is commanded", ("winch",), PAYS_OUT),
    "low_pressure": FaultKind(
        "hydraulic pressure has fallen: the drum is slower", ("winch",), "share of its speed limit, above 0"
    ),
    "clear": FaultKind("ends the faults of the device that are active at its start; later ones stay", _ALL),
}
"""The vocabulary: every kind of fault by its name."""

LARGEST_DELAY = {"mru": 10.0}
"""Largest magnitude of a delay or jitter [s], of devices that keep no longer record."""


def faults_of(device: str) -> tuple[str, ...]:
    """Return the kinds of fault that a kind of device knows."""
    return tuple(kind for kind, fault in FAULTS.items() if device in fault.devices)
