"""A record of somebody else's system, judged by a procedure: columns or a bag, through a map."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from heave_bags.mcap.read.folder import bag_of
from heave_bags.signals import RunSignals, Signal
from heave_devices.bench.set_signal import Event, WinchTest
from heave_devices.bench.winch import Trace
from heave_devices.maps.channel import Channel
from heave_devices.records.sample_checks import Findings
from heave_devices.records.sea_import import record_channels
from heave_devices.records.sea_mapping import SeaMapping, read_mapping
from heave_devices.records.ship_log import is_text

from heave_studies.accept.measured import Measured, Nominal, rate_of
from heave_studies.accept.parts.run import depth_of, read_loop
from heave_studies.accept.procedure import Step
from heave_studies.accept.results import lacking_words

QUANTITIES = ("heave", "payout", "payout_rate", "ordered_rate", "unit_heave", "tension", "pressure")
"""Quantities of a map that are used: heave of the boom tip, those of the winch, heave of the unit, pressure at it."""
OWN = SeaMapping(
    {
        name: Channel(column=column)
        for name, column in zip(("ordered_rate", "payout", "payout_rate"), Trace.HEADER[1:4], strict=True)
    },
    time_column=Trace.HEADER[0],
)
"""Map of what a test of a winch leaves."""


SILENCED: Mapping[str, tuple[str, ...]] = {
    "mru": ("heave",),
    "depth": ("depth", "pressure", "unit_heave"),
    "load_cell": ("tension",),
    "encoder": ("payout", "payout_rate"),
}
"""Quantities that an event of a device may silence."""


class ForeignRecord:
    """A record.

    Parameters
    ----------
    source : bag, log in columns, or what a device sent
    mapping : map file; None: a bag of the suite's topics, or what a test of a winch left

    Raises BagError for what cannot be read.
    """

    def __init__(self, source: Path, mapping: Path | None) -> None:
        self.source = bag_of(source)
        self.notes: list[str] = []
        self._signals: dict[str, Signal] = {}
        self._is_own = mapping is None and not is_text(self.source)
        if self._is_own:
            return
        self._is_of_winch = mapping is None
        findings = Findings(accepts=True)
        found = OWN if mapping is None else read_mapping(mapping, QUANTITIES)
        self._signals = record_channels(self.source, found, findings)
        self.notes = findings.notes

    def measured(self, step: Step, nominal: Nominal) -> Measured:
        """Return what figures of a `step` are computed from, of a winch that should be `nominal`.

        Times of the step count from the start of the record.
        """
        if self._is_own:
            done = read_loop(self.source, step.event, step.event.at if step.event else None)
            measured = done.measured
            measured.start = max(measured.start, step.window[0])
            end = step.window[1] if math.isfinite(step.window[1]) else measured.end
            motions = (measured.run.payout, measured.run.boom_tip_heave, measured.run.unit_heave)
            whole = Signal(np.unique(np.concatenate([of.time for of in motions])))
            measured.lacks = lacking_words([whole], (measured.start, end))
            measured.end = min(measured.end, end)
            measured.nominal = nominal
            return measured
        first = min(float(signal.time[0]) for signal in self._signals.values())
        signals = {name: Signal(signal.time - first, signal.value) for name, signal in self._signals.items()}
        run = _run_signals(signals)
        last = max(float(signal.time[-1]) for signal in signals.values())
        measured = Measured(run, step.window[0], min(step.window[1], last), nominal=nominal, notes=list(self.notes))
        measured.ordered_rate = signals.get("ordered_rate", Signal())
        names = {"mru": "heave", "depth": "depth", "load_cell": "tension", "encoder": "payout"}
        measured.readings = {name: signals[of] for name, of in names.items() if of in signals}
        if step.event is not None:
            measured.event = step.event.at
            measured.event_end = step.event.at + step.event.duration
        measured.lacks = self._lacking(step, signals, last)
        return measured

    def _lacking(self, step: Step, signals: Mapping[str, Signal], last: float) -> str:
        """Return what the record lacks of what a `step` is judged over, in words; it ends at `last` [s]."""
        if self._is_of_winch and isinstance(step.test, WinchTest) and step.event is None:
            last = step.test.signal.duration
        end = step.window[1] if math.isfinite(step.window[1]) else last
        event = step.event or Event("", "", math.nan)
        silenced = [name for name in SILENCED.get(event.device, ()) if name in signals]
        # an order holds until the next
        steady = [of for name, of in signals.items() if name not in ("ordered_rate", *silenced)]
        span = (event.at, event.at + (event.duration or math.inf))
        return lacking_words(steady, (step.window[0], end), [(signals[name], span) for name in silenced])


def _run_signals(signals: dict[str, Signal]) -> RunSignals:
    """Return the signals of a run; a unit that has no heave of its own has that of its pressure sensor."""
    if "pressure" in signals:
        pressure = signals["pressure"]
        signals["depth"] = Signal(pressure.time, depth_of(pressure.value))
        signals.setdefault("unit_heave", Signal(pressure.time, -signals["depth"].value))
    empty = Signal()
    run = RunSignals(
        boom_tip_heave=signals.get("heave", empty),
        unit_heave=signals.get("unit_heave", empty),
        payout=signals.get("payout", empty),
        payout_rate=signals.get("payout_rate", empty),
        tension=signals.get("tension", empty),
        speed_limit=math.inf,
    )
    if not run.payout_rate.size and run.payout.size > 2:
        run.payout_rate = rate_of(run.payout)
    return run
