"""What is said of devices: as diagnostics once a second, and as a table at the end."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence

from heave_bringup.output import make_table
from heave_node.ros.diagnostics import Health, Level
from rich.table import Table

from heave_devices.adapt.device import LiveDevice
from heave_devices.adapt.links import LinkReader
from heave_devices.adapt.plc.polled import PolledLink
from heave_devices.live.counted_time import LARGEST_RATE, LEAST_RATE


def figures_of(device: LiveDevice) -> dict[str, float]:
    """Return what was counted of a `device`, by name with unit; wrong ones are 0 where all is well."""
    adapter, counters = device.adapter, device.counters
    watch, taker = adapter.watch, adapter.taker.counters
    figures: dict[str, float] = {
        "readings": sum(adapter.published.values()),
        "interval_s": watch.usual_interval,
        "longest_gap_s": watch.longest_gap,
        "gaps": watch.gaps,
        "bursts": watch.bursts,
        "timeouts": watch.timeouts,
        "invalid": taker.invalid,
        "implausible": sum(taker.implausible.values()),
        "missing_fields": sum(taker.missing.values()),
        "time_glitches": sum(clock.glitches for clock in adapter.clocks.values()),
        "clock_restarts": sum(clock.restarts for clock in adapter.clocks.values()),
        "old_samples": sum(clock.late for clock in adapter.clocks.values()),
        "times_too_coarse": sum(clock.standing for clock in adapter.clocks.values()),
    }
    if device.link is not None:
        figures["link_failures"] = device.link.failures
    if isinstance(device.link, LinkReader) and device.link.link.kind == "udp":
        figures["other_senders"] = device.link.strangers
    if counters is not None:
        figures |= {
            "bytes": counters.bytes,
            "checksum_errors": counters.checksum_errors,
            "incomplete_lines": counters.incomplete_lines,
            "malformed": counters.malformed,
            "unknown": sum(counters.unknown.values()),
        }
        if device.device.layout is not None:
            figures |= {"lost": counters.lost, "repeated": counters.repeated, "late": counters.late}
    if isinstance(device.link, PolledLink):
        link = device.link
        figures |= {"reads": link.reads, "writes": link.writes, "refusals": link.refusals, "connections": link.opened}
    if device.device.command is not None:
        figures["commands_sent"] = device.orders.sent
    return figures


_WRONG = (
    *("gaps", "bursts", "timeouts", "invalid", "checksum_errors", "incomplete_lines", "malformed", "lost", "refusals"),
    *("time_glitches", "clock_restarts", "old_samples", "other_senders", "times_too_coarse"),
)


def health_of(device: LiveDevice, before: Mapping[str, float]) -> Health:
    """Return the health of a `device`: what has gone wrong since its figures `before`, a second ago, is a warning."""
    figures = figures_of(device)
    now = time.monotonic()
    values = {name: f"{value:.6g}" for name, value in figures.items()}
    values |= {f"newest {name}": f"{value:.4g}" for name, value in device.adapter.newest.items()}
    taker = device.adapter.taker.counters
    more = {name: figures.get(name, 0) - before.get(name, 0) for name in _WRONG}
    words = [f"{name.replace('_', ' ')} +{count:g}" for name, count in more.items() if count > 0]
    name = device.device.name
    errors = {
        f"{device.device.link or 'link'}: {device.problem}": bool(device.problem),
        f"{device.device.link}: {device.link.failed if device.link else ''}": (
            figures.get("link_failures", 0) > before.get("link_failures", 0)
        ),
        device.adapter.speed_travel.words: bool(device.adapter.speed_travel.words),
        "; ".join(taker.missing): figures["missing_fields"] > before.get("missing_fields", 0),
        f"not used: {taker.worst}": figures["implausible"] > before.get("implausible", 0),
        (clock := clock_words(device)): bool(clock),
    }
    if error := next((text for text, is_present in errors.items() if is_present), ""):
        return Health(name, Level.ERROR, error, values)
    if device.adapter.watch.is_stale(now):
        return Health(name, Level.STALE, stale_words(device, now, before), values)
    if words:
        return Health(name, Level.WARN, ", ".join(words), values)
    return Health(name, values=values)


def clock_words(device: LiveDevice) -> str:
    """Return in words that the own time of a `device` is none, or has another unit; "": it is one, or not yet known."""
    for rate in [clock.rate for clock in device.adapter.clocks.values() if device.device.clock == "own"]:
        if not LEAST_RATE < rate < LARGEST_RATE and math.isfinite(rate):
            what = f"runs {rate:.3g} times as fast as time passes" if rate else "stands still"
            return f"its own time {what}: check unit and scale of the map's device_time, or write clock: receipt"
    return ""


def stale_words(device: LiveDevice, now: float, before: Mapping[str, float] | None = None) -> str:
    """Return in words that nothing usable comes from a `device` `now` [s], and the likely cause.

    `before` are its figures a second ago; None: none were taken.
    """
    age = device.adapter.watch.age(now)
    since = "no reading yet" if math.isnan(age) else f"no reading for {age:.1f} s"
    if not device.adapter.is_counting and "watchdog" in device.adapter.newest:
        stood = "stands still" if math.isnan(age) else f"has not counted for {age:.1f} s"
        return f"watchdog {stood}. Check that the PLC's program runs, and the map's watchdog"
    return f"{since}: {_cause_of_silence(device, before or {})}"


def _cause_of_silence(device: LiveDevice, before: Mapping[str, float]) -> str:
    counters, taker = device.counters, device.adapter.taker.counters
    unavailable = ", ".join(f"{name} reads {value:.10g}" for name, value in taker.unavailable.items())
    is_silent = counters is not None and counters.bytes == before.get("bytes", 0)
    broken = counters.checksum_errors - before.get("checksum_errors", 0) if counters is not None else 0
    old = figures_of(device)["old_samples"] - before.get("old_samples", 0)
    causes = [
        ("nothing received. Check power, cable, address and baud rate", is_silent),
        ("its own time goes back. Check the map's device_time and clock", old > 0),
        (f"{broken:g} wrong checksums. Check cable, baud rate and the map's checksum", broken > 0),
        (f"{unavailable}, which stands for not available. Check the drive or sensor: is it referenced?", unavailable),
        (taker.worst, taker.worst),
        ("what it answers is invalid. Check the PLC", isinstance(device.link, PolledLink) and device.link.reads),
        ("nothing received. Check power, cable, address and baud rate", counters is None),
    ]
    if counters is not None and not counters.samples:
        unknown = ", ".join(list(counters.unknown)[:5])
        causes.append((f"only unknown lines: {unknown}. Check the map's format", unknown))
        causes.append((f"{counters.bytes} bytes, none as the format has it. Check format and baud rate", True))
    causes.append(("what comes lacks the map's fields, or is invalid", True))
    return next(words for words, is_so in causes if is_so)


def summary_table(devices: Sequence[LiveDevice]) -> Table:
    """Return the table of what came from all `devices`."""
    names = list(dict.fromkeys(name for device in devices for name in figures_of(device)))
    rows = []
    for name in names:
        figures = [figures_of(device).get(name, math.nan) for device in devices]
        rows.append([name.replace("_", " "), *("-" if math.isnan(value) else f"{value:.6g}" for value in figures)])
    return make_table(("count", *(device.device.name for device in devices)), rows)
