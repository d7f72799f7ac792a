"""A record of sensors from a bag of others, a log in columns, or what a device sent, through a map.

The map is that of `heave accept --map` and of `heave adapt`: each quantity is where the map says. Times may be of a
host's clock. The first reading is in tick 1, and payout counts from there: the scenario says the length that was out.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from heave_bags.analyse.time_base import LONGEST_GAP
from heave_bags.signals import Signal
from heave_bringup.errors import CommandError
from heave_devices.live.mru_maker import MruMaker
from heave_devices.live.taker import Taken
from heave_devices.maps.channel import Channel
from heave_devices.maps.device_map import DeviceMap, read_device_map
from heave_devices.maps.quantities import OUTPUTS
from heave_devices.records.sample_checks import Findings
from heave_devices.records.sea_import import record_channels
from heave_devices.records.sea_mapping import read_mapping
from heave_node.files.plausible import question
from heave_node.interface.sensors import MRU, STANDARD_WATER, Water, WireReading
from heave_node.numerics.constants import ATMOSPHERIC_PRESSURE
from heave_node.sensing.recent_motion import RecentMotion
from winch_controller_node.design.design import assumed_plant
from winch_controller_node.interface.conversions import measurements
from winch_controller_node.interface.readings import WinchOrder, WinchReading
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.whatif.signals.record import LOST, Loss, SensorRecord
from heave_studies.whatif.signals.spectra import BAND, tapered_transform

OF_MRU = tuple(itertools.chain(*OUTPUTS[MRU.topic.name]))
BESIDE = ("unit_heave", "pressure", "tension", "payout", "payout_rate", "ordered_rate")
Signals = dict[str, Signal]

LONGEST_COMPARED = 900.0
"""Part of a record, its last, over which a motion is compared with its rate [s]."""

TOGETHER = 0.5
"""Coherence above which a motion and its rate show how large one is over the other."""

FIRST = 10
"""Readings of the depth at the start that are compared with the cable that was out then."""

_SECOND = 1_000_000_000
EARLY = 0.02
"""A reading belongs to a tick that it comes so little after, in ticks: stamps are rounded to the millisecond."""


def read_others(
    source: Path, mapping: Path, nominal: WinchControllerParameters, tick_period: float
) -> tuple[SensorRecord, list[str]]:
    """Return the record of sensors in a `source`, and what is to be said of how it was read.

    Parameters
    ----------
    source : bag, log in columns, or what a device sent
    mapping : map file
    nominal : parameters of the controller that is to be tried in it
    tick_period : of that controller [s]

    Raises BagError for what cannot be read, CommandError where the record lacks what every answer needs.
    """
    findings = Findings()
    signals = record_channels(source, read_mapping(mapping, (*OF_MRU, *BESIDE)), findings)
    device = read_device_map(mapping)
    _check(source, signals, mapping, device)
    water = Water(nominal.water_density, nominal.gravity)
    _ask(signals, nominal, water, findings)
    if findings.questions:
        raise CommandError(f"{source}: {findings.questions[0]} Say it in the map, or leave that column out of it")
    # a host's clock counts from 1970: from the first tick on, no digits are lost
    before = min(float(one.time[0]) for one in signals.values()) - tick_period
    signals = {name: Signal(one.time - before, one.value) for name, one in signals.items()}
    holes = [one for one in _gaps("load_cell", signals.get("tension", Signal())) if one.end - one.start > LOST]
    if holes:
        del signals["tension"]
        first = f"tension: no number came from {holes[0].start:.1f} s to {holes[0].end:.1f} s"
        findings.notes.append(f"{first}: the load cell is not used")
    needed = ("heave", "payout", "pressure" if "pressure" in signals else "unit_heave")
    ticks = math.floor(min(float(signals[name].time[-1]) for name in needed) / tick_period + EARLY)
    delivered = {
        MRU.name: _by_tick(_mru(signals, device), tick_period),
        "depth": _by_tick(_pressures(signals, nominal.length, water), tick_period),
        "load_cell": _by_tick(_plain(signals.get("tension", Signal())), tick_period),
    }
    winches = _winches(signals, tick_period)
    taken = tuple(
        measurements({name: found.get(tick, []) for name, found in delivered.items()}, winches.get(tick), water)
        for tick in range(1, ticks + 1)
    )
    orders = _orders(signals, ticks, tick_period)
    unknown = np.full(ticks, math.nan)
    sensors = zip(("mru", "encoder", "depth"), needed, strict=True)
    losses = tuple(loss for sensor, name in sensors for loss in _gaps(sensor, signals[name]))
    record = SensorRecord(tick_period, 1, taken, orders, unknown, ("",) * ticks, losses=losses, is_own=False)
    return record, findings.notes


def _gaps(sensor: str, signal: Signal) -> Iterable[Loss]:
    """Return when a `sensor` gave no number for longer than it does between most of those of its `signal`."""
    between = np.diff(signal.time)
    for place in np.flatnonzero(between > LONGEST_GAP * np.median(between)) if between.size else ():
        yield Loss(sensor, float(signal.time[place]), float(signal.time[place + 1]), "no number came")


def _check(source: Path, signals: Signals, mapping: Path, device: DeviceMap) -> None:
    """Refuse a record whose `signals`, by a `mapping` that was read as `device`, lack what every answer needs."""
    needed = {
        ("heave",): "the boom tip's motion is not known",
        ("payout",): "what the drum did is not known",
        ("pressure", "unit_heave"): "the unit's motion is not measured, so it cannot be predicted",
    }
    for names, why in needed.items():
        if signals.keys().isdisjoint(names):
            raise CommandError(f"{source}: the map names no {' or '.join(names)}: {why}")
    wrong = next((name for name in OF_MRU if name in device.channels and _is_derived(device.channels[name])), None)
    if wrong is not None:
        raise CommandError(f"{mapping}: {wrong}: of a velocity, or an acceleration, no heave is made here: give it")


def _ask(signals: Signals, nominal: WinchControllerParameters, water: Water, findings: Findings) -> None:
    """Ask in `findings` for what `signals` of one record cannot be together, in `water`, or as `nominal` has it."""
    heave = signals["heave"]
    findings.ask("" if np.ptp(heave.value) > 0.0 else "heave never changes: another column?")
    if "heave_rate" in signals:
        share = over_integral(heave, signals["heave_rate"])
        findings.ask(question("heave over the integral of heave rate", share))
    if "payout_rate" in signals:
        share = over_integral(signals["payout"], signals["payout_rate"])
        findings.ask(question("payout over the integral of payout rate", share))
    if "pressure" in signals:
        depth = (float(np.median(signals["pressure"].value[:FIRST])) - ATMOSPHERIC_PRESSURE) / water.pressure_per_metre
        findings.ask(question("depth by pressure over the cable that is out", depth / nominal.length))
    if "tension" in signals:
        weight = assumed_plant(nominal).line(nominal.length).static_top_tension(nominal.length)
        share = float(np.median(signals["tension"].value)) / weight
        findings.ask(question("tension over the weight of cable and unit", share))


def over_integral(motion: Signal, rate: Signal) -> float:
    """Return how many times the integral of a `rate` is in a `motion`, in the band of waves; 1 in noise [-]."""
    start, end = max(motion.time[0], rate.time[0]), min(motion.time[-1], rate.time[-1])
    start = max(start, end - LONGEST_COMPARED)
    if end - start < 2.0 * math.pi / BAND[0]:
        return 1.0
    omegas = np.arange(*BAND, 2.0 * math.pi / (end - start))
    was = tapered_transform(motion.time, motion.value, omegas, start, end)
    by = tapered_transform(rate.time, rate.value, omegas, start, end) / (1j * omegas)
    shared, power = float(np.vdot(by, was).real), float(np.vdot(by, by).real)
    is_hidden = shared**2 <= TOGETHER * power * float(np.vdot(was, was).real)
    return 1.0 if is_hidden else shared / power


def _mru(signals: Signals, device: DeviceMap) -> Iterable[WireReading]:
    """Return the readings of the boom tip, carried there from the sensor as a live one's are."""
    times = np.unique(np.concatenate([signals[name].time for name in OF_MRU if name in signals]))
    values: dict[float, dict[str, float]] = {time: {} for time in times.tolist()}
    for name in OF_MRU:
        signal = signals.get(name, Signal())
        # a height counts from its mean, as a heave does
        mean = signal.value.mean() if name in device.channels and device.channels[name].high_pass else 0.0
        for time, value in zip(signal.time.tolist(), (signal.value - mean).tolist(), strict=True):
            values[time][name] = value
    maker = MruMaker(device)
    for time, of_time in values.items():
        sample = maker.take(Taken(time, of_time))
        if sample is not None:
            yield WireReading(round(time * _SECOND), MRU.encode(sample, STANDARD_WATER))


def _is_derived(channel: Channel) -> bool:
    return channel.velocity or channel.acceleration


def _pressures(signals: Signals, length: float, water: Water) -> Iterable[WireReading]:
    """Return absolute pressures at the unit; by its heave about a depth of `length` [m] in `water` where none are."""
    if "pressure" in signals:
        return _plain(signals["pressure"])
    heave = signals["unit_heave"]
    return _plain(Signal(heave.time, ATMOSPHERIC_PRESSURE + water.pressure_per_metre * (length - heave.value)))


def _plain(signal: Signal) -> Iterable[WireReading]:
    """Return the readings of a sensor with one number, its accuracy not stated."""
    for time, value in zip(signal.time.tolist(), signal.value.tolist(), strict=True):
        yield WireReading(round(time * _SECOND), (value, 0.0))


def _tick_of(time: float, tick_period: float) -> int:
    return math.ceil(time / tick_period - EARLY)


def _by_tick(readings: Iterable[WireReading], tick_period: float) -> dict[int, list[WireReading]]:
    """Return readings by the tick in which a controller would have got them: the first one after they were taken."""
    found: dict[int, list[WireReading]] = {}
    for reading in readings:
        found.setdefault(_tick_of(reading.time, tick_period), []).append(reading)
    return found


def _winches(signals: Signals, tick_period: float) -> dict[int, WinchReading]:
    """Return the newest state of the winch in each tick, payout counted from the first reading."""
    payout, recent, found = signals["payout"], RecentMotion(), {}
    rates = signals["payout_rate"].at(payout) if "payout_rate" in signals else np.full(payout.size, math.nan)
    for time, value, rate in zip(payout.time.tolist(), (payout.value - payout.value[0]).tolist(), rates, strict=True):
        recent.add(time, value)
        moved = recent.at(time)
        speed = float(rate) if math.isfinite(rate) else 0.0 if moved is None else moved[1]
        found[_tick_of(time, tick_period)] = WinchReading(time, value, speed, brake=False)
    return found


def _orders(signals: Signals, ticks: int, tick_period: float) -> tuple[WinchOrder | None, ...]:
    """Return the order of each tick, about the payout of now; none where the record has no speeds that were ordered."""
    if "ordered_rate" not in signals:
        return (None,) * ticks
    ordered, payout = signals["ordered_rate"], signals["payout"]
    time = tick_period * np.arange(1, ticks + 1)
    newest = np.searchsorted(ordered.time, time + EARLY * tick_period, side="right") - 1
    rates = np.where(newest < 0, 0.0, ordered.value[np.maximum(newest, 0)])
    paid = np.interp(time, payout.time, payout.value - payout.value[0])
    return tuple(
        WinchOrder(tick, at, rate, brake=False)
        for tick, (at, rate) in enumerate(zip(paid.tolist(), rates.tolist(), strict=True), start=1)
    )
