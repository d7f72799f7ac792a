"""What became of a procedure: the verdict on each step, on the whole, and what identifies what was judged."""

from __future__ import annotations

import hashlib
import math
import platform
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from heave_bags.analyse.time_base import LONGEST_GAP
from heave_bags.analyse.verdict import FAILED, PASSED, Judged, required_words
from heave_bags.record.provenance import git_commit, versions
from heave_bags.report.figure import BOOM_TIP, CM, KN, PAYOUT, UNCOMPENSATED, UNIT, Figure, line
from heave_bags.signals import Signal
from heave_devices.records.stretches import DEFAULT_BRIDGE

from heave_studies.accept.measured import RESIDUALS, Measured
from heave_studies.accept.procedure import Procedure, Step

NOT_DONE = "not done"
"""State of a step that was not run, or could not be."""


@dataclass(frozen=True)
class StepResult:
    """What became of a step."""

    step: Step  # of the procedure
    judged: tuple[Judged, ...] = ()  # its criteria
    breaches: tuple[str, ...] = ()  # what fails any run, in words
    failure: str = ""  # why it could not be done; "": it could
    values: Mapping[str, float] = field(default_factory=dict)  # every figure that is known
    measured: Measured | None = None  # its signals; None: it was not done
    file: Path | None = None  # what it left, a bag or a table; None: nothing
    digest: str = ""  # of that file
    part: str = ""  # what it was run against, in words

    @property
    def state(self) -> str:
        """The verdict in a word: passed, FAILED, or not done."""
        if self.failure or self.measured is None:
            return NOT_DONE
        return PASSED if not self.breaches and all(one.is_met for one in self.judged) else FAILED

    @property
    def failures(self) -> list[str]:
        """What is missed, in words."""
        if self.state == NOT_DONE:
            return [f"{NOT_DONE}: {self.failure or 'interrupted'}"]
        return [*self.breaches, *(str(one) for one in self.judged if not one.is_met)]

    def to_plain(self) -> dict[str, object]:
        """Return it as plain data: what the table, the page and a machine have of it."""
        signal = getattr(self.step.test, "signal", None)
        done = [signal.words if signal else "", f"event: {self.step.event.words}" if self.step.event else ""]
        return {
            "step": self.step.name,
            "what": self.step.what,
            "done": [*(words for words in done if words), *self.breaches],
            "state": self.state,
            "part": self.part,
            "failure": self.failure,
            "criteria": [one.to_json() for one in self.judged],
            "cells": [[*cells(one), "met" if one.is_met else FAILED] for one in self.judged],
            "failures": self.failures if self.state != PASSED else [],
            "residuals": {key: self.values.get(key, math.nan) for key in RESIDUALS},
            "notes": list(self.measured.notes) if self.measured else [],
            "figures": [asdict(one) for one in figures_of(self.measured)] if self.measured else [],
            "file": self.file.name if self.file else None,
            "sha256": self.digest or None,
            "began": time.time(),
        }


def facts_of(procedure: Procedure, scenario: str) -> dict[str, str]:
    """Return what identifies an acceptance test.

    Parameters
    ----------
    procedure : that was run
    scenario : text of its scenario with all values
    """
    known = versions()
    return {
        "procedure": f"{procedure.path.name}, SHA-256 {hashlib.sha256(procedure.text).hexdigest()}",
        "scenario": f"{procedure.scenario} with all values, SHA-256 {hashlib.sha256(scenario.encode()).hexdigest()}",
        "software": ", ".join(f"{name} {version}" for name, version in known.items()),
        "commit": git_commit() or "unknown",
        "host": f"{platform.node()}, {platform.system()} {platform.machine()}",
    }


Span = tuple[float, float]
"""Start and end [s]."""


def lacking_words(signals: Iterable[Signal], window: Span, excused: Iterable[tuple[Signal, Span]] = ()) -> str:
    """Return in words that a record lacks part of a window; "" where it has all of it.

    Within the window gaps up to DEFAULT_BRIDGE count as recorded, as `heave import` has it. At its ends a signal may
    lack LONGEST_GAP of its periods, as in tables.

    Parameters
    ----------
    signals : each of which must be there
    window : that is judged
    excused : further signals, each with the time of an event that may silence it
    """
    start, end = window
    if not end > start:
        return f"nothing to judge from {start:g} s to {end:g} s"
    gaps = [gap for signal in signals for gap in _gaps(signal, window)]
    gaps += [
        gap for signal, event in excused for gap in _gaps(signal, window) if gap[1] < event[0] or gap[0] > event[1]
    ]
    missing, known = 0.0, start
    for first, last in sorted(gaps):
        missing += max(last - max(first, known), 0.0)
        known = max(known, last)
    if not missing:
        return ""
    return f"{math.floor(10.0 * (end - start - missing)) / 10.0:g} s of {end - start:g} s recorded"


def _gaps(signal: Signal, window: Span) -> list[Span]:
    """Return the gaps of a signal within a window that nothing bridges."""
    inside = signal.window(*window).time
    edges = np.concatenate((window[:1], inside, window[1:]))
    bridged = np.full(edges.size - 1, DEFAULT_BRIDGE)
    period = float(np.median(np.diff(inside))) if inside.size > 1 else 0.0
    bridged[[0, -1]] = min(LONGEST_GAP * period, DEFAULT_BRIDGE)
    return [(float(edges[at]), float(edges[at + 1])) for at in np.flatnonzero(np.diff(edges) > bridged)]


def cells(judged: Judged) -> tuple[str, str, str]:
    """Return title, required and reached of a criterion that was `judged`."""
    definition = judged.definition
    title = definition.title if definition else judged.criterion.kpi
    return title, required_words(judged.criterion, judged.known), judged.got


def figures_of(one: Measured) -> list[Figure]:
    """Return the figures of what a step left: `one`."""
    run, ordered = one.run, one.ordered_rate
    rates = [("measured", run.payout_rate, PAYOUT), ("ordered", ordered, UNCOMPENSATED)]
    motions = [
        ("boom tip", run.boom_tip_heave, BOOM_TIP),
        ("payout", run.payout, PAYOUT),
        ("unit, off", run.uncompensated_heave, UNCOMPENSATED),
        ("unit", run.unit_heave, UNIT),
    ]
    found = [_drawn(one, "Payout rate", "payout rate [m/s]", rates, 1.0)] if ordered.value.any() else []
    if run.boom_tip_heave.size or run.unit_heave.size:
        about = [(name, Signal(of.time, of.value - of.value.mean()) if of.size else of, c) for name, of, c in motions]
        found.append(_drawn(one, "Motions about their means", "motion [cm]", about, CM))
        if run.tension.size:
            found.append(_drawn(one, "Top tension", "tension [kN]", [("tension", run.tension, UNIT)], KN))
    elif run.payout.size and not found:
        found.append(_drawn(one, "Payout", "payout [m]", [("payout", run.payout, PAYOUT)], 1.0))
    return found


def _drawn(
    measured: Measured, title: str, axis: str, traces: Sequence[tuple[str, Signal, str]], scale: float
) -> Figure:
    lines = [line(Signal(of.time, scale * of.value), name, colour) for name, of, colour in traces if of.size]
    shapes = [
        {"type": "line", "x0": at, "x1": at, "yref": "paper", "y0": 0, "y1": 1, "line": {"dash": "dot", "width": 1}}
        for at in (measured.event, measured.stop)
        if math.isfinite(at)
    ]
    layout = {"xaxis": {"title": {"text": "time [s]"}}, "yaxis": {"title": {"text": axis}}, "shapes": shapes}
    caption = "Dotted: the event, and the drum at rest." if shapes else ""
    return Figure(title, caption, lines, layout, height=260, is_over_time=False)
