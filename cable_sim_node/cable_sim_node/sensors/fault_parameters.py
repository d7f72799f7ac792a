"""Faults of a sensor, the winch or a line, scheduled by simulated time, as parameters."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import parameter

SENSOR_FAULT_KINDS = ("freeze", "gap", "spike", "jump", "nan", "rate", "delay")
ENCODER_FAULT_KINDS = ("freeze", "spike", "jump", "nan")
WINCH_FAULT_KINDS = ("gap", "delay", "drive", "emergency_stop")
FAULT_KINDS = ("freeze", "gap", "spike", "jump", "nan", "rate", "delay", "drive", "emergency_stop")


@dataclass(frozen=True)
class FaultParameters:
    """A list of faults, one per position of the four lists (parameter files have no lists of records).

    | kind | what happens from `start` for `duration` | `magnitude` |
    |---|---|---|
    | freeze | the value of the last sample before `start` is repeated with fresh stamps | not used |
    | gap | no samples; winch: commands are lost | not used |
    | spike | the first sample is off by `magnitude` on all axes, the next ones are right again | in the sensor's unit |
    | jump | every sample is off by `magnitude` on all axes | in the sensor's unit |
    | nan | every sample is not a number | not used |
    | rate | samples come at this rate | Hz, above 0 |
    | delay | samples or commands come later by this much | s, at least 0 |
    | drive | winch: the drive trips | not used |
    | emergency_stop | winch: the emergency stop is pressed | not used |

    A sensor knows the first seven kinds, the encoder freeze, spike, jump and nan, and the winch gap, delay, drive and
    emergency_stop.
    """

    kind: tuple[str, ...] = parameter((), unit="", choices=FAULT_KINDS, description="Kinds of the scheduled faults.")
    start: tuple[float, ...] = parameter((), unit="s", minimum=0.0, description="Start of each fault, simulated time.")
    duration: tuple[float, ...] = parameter(
        (), unit="s", minimum=0.0, description="Duration of each fault; 0 means to the end of the run."
    )
    magnitude: tuple[float, ...] = parameter(
        (), unit="", description="Magnitude of each fault: sensor's unit for spike and jump, Hz for rate, s for delay."
    )

    def __post_init__(self) -> None:
        """Refuse lists of unequal length and magnitudes a kind cannot have."""
        lengths = [len(self.kind), len(self.start), len(self.duration), len(self.magnitude)]
        if len(set(lengths)) > 1:
            raise ValueError(
                "faults: kind, start, duration and magnitude must have as many values each; "
                f"got {', '.join(map(str, lengths))}"
            )
        for kind, magnitude in zip(self.kind, self.magnitude, strict=True):
            check_magnitude(kind, magnitude)

    def require_kinds(self, known: tuple[str, ...], device: str) -> None:
        """Raise ValueError if a kind is not one that `device` can have."""
        for kind in self.kind:
            check_kind(kind, known, device)


def check_kind(kind: str, known: tuple[str, ...], device: str) -> None:
    """Raise ValueError if `kind` is not among the `known` kinds of `device`."""
    if kind not in known:
        raise ValueError(f"{device}: a fault of kind {kind} is not known here; known: {', '.join(known)}")


def check_magnitude(kind: str, magnitude: float) -> None:
    """Raise ValueError if a fault of `kind` cannot have `magnitude`."""
    if kind == "rate" and magnitude <= 0.0:
        raise ValueError(f"faults: the magnitude of kind rate must be above 0 Hz; got {magnitude:g}")
    if kind == "delay" and magnitude < 0.0:
        raise ValueError(f"faults: the magnitude of kind delay must be at least 0 s; got {magnitude:g}")
