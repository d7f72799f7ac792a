"""What was heard of a live external node, held against its contract; without ROS."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from heave_node.interface.codes import WinchRelease
from heave_node.tick.clock_rule import ClockRule
from heave_node.tick.external_clock import ExternalClock

from heave_bringup.external.contract import Port

SLOW = 0.8
"""A rate below this share of the wanted one is too low."""
OLD = 0.5
"""A stamp of simulated time may be so much older than the clock at the arrival of its message [s]."""
REACTION = 1.5
"""Time within which a winch must have obeyed a command, or noticed that commands have stopped [s]."""


@dataclass
class Heard:
    """What came on one topic."""

    # names of the nodes that publish it, each with its host-wide unique namespace
    publishers: list[str] = field(default_factory=list)
    types: list[str] = field(default_factory=list)  # of these publishers
    refusals: list[str] = field(default_factory=list)  # quality of service that does not match, in words
    arrivals: list[float] = field(default_factory=list)  # wall time of each message [s]
    stamps: list[float] = field(default_factory=list)  # stamp of each message [s]
    clock: list[float] = field(default_factory=list)  # simulated time when each message came [s]
    bad: dict[str, int] = field(default_factory=dict)  # fields that were no plausible number, with how often
    counter: list[int] = field(default_factory=list)  # values of the field that counts


@dataclass(frozen=True)
class Finding:
    """One line of the table."""

    topic: str  # that was looked at
    what: str  # what of it
    is_good: bool  # it is as the contract says
    words: str  # what was found


def judge_topic(port: Port, heard: Heard, rule: ClockRule = ClockRule.DETECT) -> list[Finding]:
    """Return what is to be said of one topic that a node publishes: as it must be, `port`; as it was `heard`; by the
    `rule` by which the node stamps, as declared.
    """
    name = port.topic.name

    def finding(what: str, is_good: bool, words: str) -> Finding:
        return Finding(name, what, is_good, words)

    if not heard.publishers:
        alone = "" if name != "boom_tip" else ". For a motion sensor alone beside the simulated vessel: mru=external"
        return [finding("publisher", not port.is_required, f"it has no publisher{alone}")]
    found = [finding("publisher", len(heard.publishers) == 1, ", ".join(heard.publishers))]
    wrong = sorted(set(heard.types) - {port.topic.type})
    found.append(finding("type", not wrong, ", ".join(wrong) or port.topic.type))
    found.append(finding("quality of service", not heard.refusals, "; ".join(heard.refusals) or "matches"))
    if wrong or heard.refusals:
        return found
    if not heard.arrivals:
        words = "none received: does the node receive clock, and serve its callbacks (EventsExecutor: by spin_once)?"
        return [*found, finding("messages", False, words)]
    return [*found, _rate(port, heard), _stamps(port, heard, rule), _numbers(port, heard), *_counter(port, heard)]


def _rate(port: Port, heard: Heard) -> Finding:
    intervals = np.diff(heard.arrivals)
    if not intervals.size:
        return Finding(port.topic.name, "rate", False, "only one message")
    rate, jitter = 1.0 / float(np.mean(intervals)), float(np.std(intervals))
    wanted = f" (expected {port.rate:g})" if port.rate else ""
    words = f"{rate:.1f} Hz{wanted}, jitter {1e3 * jitter:.1f} ms, largest gap {1e3 * intervals.max():.0f} ms"
    return Finding(port.topic.name, "rate", rate >= SLOW * port.rate, words)


def _stamps(port: Port, heard: Heard, rule: ClockRule) -> Finding:
    """Hold the stamps against the declared or detected clock, as a run does."""
    clock = ExternalClock(rule)
    for stamp, arrival in zip(heard.stamps, heard.clock, strict=True):
        clock.simulated_time(round(stamp * 1e9), round(arrival * 1e9))
    name = port.topic.name
    if clock.violations:
        words = clock.violation or f"{clock.violations} messages do not match"
        return Finding(name, "clock", False, f"{clock.rule.value}: {words}")
    if clock.rule is ClockRule.NONE:
        return Finding(name, "clock", True, clock.describe())
    oldest = float(np.max(np.subtract(heard.clock, heard.stamps))) if clock.rule is ClockRule.SIMULATED else 0.0
    if oldest > OLD:
        return Finding(name, "clock", False, f"stamps are up to {oldest:.3g} s older than the clock")
    is_ordered = bool(np.all(np.diff(heard.stamps) > 0.0))
    return Finding(name, "clock", is_ordered, clock.describe() + ("" if is_ordered else "; stamps do not increase"))


def _numbers(port: Port, heard: Heard) -> Finding:
    words = ", ".join(f"{field} {count} times" for field, count in heard.bad.items())
    return Finding(
        port.topic.name, "numbers", not words, f"not plausible: {words}" if words else "finite and plausible"
    )


def _counter(port: Port, heard: Heard) -> list[Finding]:
    if not port.counter:
        return []
    steps = np.diff(heard.counter)
    gaps = int(np.count_nonzero(steps != 1))
    words = (
        f"{gaps} of {steps.size} steps are not 1" if gaps else f"counts up, {heard.counter[0]} to {heard.counter[-1]}"
    )
    return [Finding(port.topic.name, port.counter, not gaps, words)]


def is_plausible(value: float, largest: float) -> bool:
    """Return whether a `value` is a number of a magnitude of at most `largest`."""
    return math.isfinite(value) and abs(value) <= largest


@dataclass(frozen=True)
class WinchTrial:
    """What a winch reported at one time while it was braked, released, and left without commands."""

    time: float  # since the trial began [s]
    reported: int  # sequence number of the newest command sent
    taken: int  # number of the newest command it has taken
    brake: bool  # as it says
    fault: int  # as it says
    release: int  # as it says


@dataclass(frozen=True)
class Plan:
    """When a winch is braked, released, left alone, braked and released again."""

    braked: float  # end of this phase [s]
    released: float  # end of this phase [s]
    silent: float  # end of this phase [s]
    acknowledged: float  # end of this phase [s]
    end: float  # end of this phase [s]

    def phase(self, time: float) -> str:
        """Return the phase at `time` [s]."""
        ends = {
            "braked": self.braked,
            "released": self.released,
            "silent": self.silent,
            "braked again": self.acknowledged,
        }
        return next((name for name, end in ends.items() if time < end), "released again")


def judge_winch(plan: Plan, trial: Sequence[WinchTrial]) -> list[Finding]:
    """Return how a winch behaved in `trial` on brake, release and silence as in `plan`; it is never ordered to move."""

    def late(start: float, end: float) -> list[WinchTrial]:
        return [said for said in trial if min(start + REACTION, end - 0.2) <= said.time < end]

    def finding(what: str, said: list[WinchTrial], good: bool, wrong: str) -> Finding:
        return Finding(
            "winch/state", what, bool(said) and good, ("nothing was received" if not said else "yes" if good else wrong)
        )

    braked, released = late(0.0, plan.braked), late(plan.braked, plan.released)
    silent, again = late(plan.released, plan.silent), late(plan.acknowledged, plan.end)
    lag = max((said.reported - said.taken for said in released), default=0)
    return [
        finding(
            "brakes on command",
            braked,
            all(s.brake for s in braked),
            "the brake is off while the commands demand it on",
        ),
        finding("releases on command", released, not any(s.brake or s.fault for s in released), "brake on, or a fault"),
        finding("echoes command numbers", released, lag <= 20, f"command_sequence is up to {lag} commands behind"),
        finding("stops without commands", silent, all(s.brake for s in silent), "the brake is off without commands"),
        finding(
            "reports why it stopped", silent, all(s.fault == 1 for s in silent), "fault is not 1, FAULT_COMMAND_TIMEOUT"
        ),
        finding(
            "says what it waits for",
            silent,
            all(s.release == WinchRelease.BRAKE_REQUEST for s in silent),
            "release is not 1, RELEASE_BRAKE_REQUEST, while a fault is latched",
        ),
        finding(
            "releases after a fault",
            again,
            not any(s.fault or s.brake or s.release for s in again),
            "fault, brake or release remains",
        ),
    ]
