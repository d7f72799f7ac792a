"""Figures of spectra: of one run, and of several together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from heave_node.numerics.arrays import Array

from heave_bags.analyse.run_record import RunRecord
from heave_bags.report.figure import BOOM_TIP, CM, RUN_COLOURS, UNCOMPENSATED, UNIT, Figure, line
from heave_bags.signals import Signal

MINIMUM_SAMPLES = 64
SEGMENT_TIME = 200.0
"""Length of a Welch segment [s]: a resolution of 0.03 rad/s, a tenth of a swell's frequency."""
SHORTEST_PERIOD = 1e-5
"""Nobody samples the motion of a vessel faster than this [s]."""


@dataclass(frozen=True)
class Spectrum:
    """One-sided density over angular frequency: `omega` [rad/s] and `density` [unit^2 s/rad].

    Its integral is the variance.
    """

    omega: Array
    density: Array


def spectrum(signal: Signal) -> Spectrum | None:
    """Return the spectrum of an evenly sampled signal about its mean; None if it is too short."""
    if signal.size < MINIMUM_SAMPLES:
        return None
    period = float(np.median(np.diff(signal.time)))
    if not SHORTEST_PERIOD < period < SEGMENT_TIME:
        return None
    segment = min(signal.size, max(MINIMUM_SAMPLES, round(SEGMENT_TIME / period)))
    frequency, density = scipy.signal.welch(signal.value, fs=1.0 / period, nperseg=segment, detrend="constant")
    return Spectrum(2.0 * np.pi * frequency[1:], density[1:] / (2.0 * np.pi))


def transmissibility(output: Spectrum, driver: Spectrum, floor: float = 1e-4) -> Spectrum:
    """Return `sqrt(S_output / S_driver)` of the spectra `output` and `driver`.

    Only where the driver has at least `floor` of its peak density.
    """
    density = np.interp(driver.omega, output.omega, output.density)
    excited = driver.density > floor * driver.density.max()
    return Spectrum(driver.omega[excited], np.sqrt(density[excited] / driver.density[excited]))


HIGHEST_OMEGA = 4.0
"""Spectra are in the page up to this angular frequency [rad/s]; a sea has nothing above it."""
SHOWN_OMEGA = 2.5
"""Spectra are shown up to this angular frequency [rad/s] before anyone zooms."""
SCALED_FLOOR = 1e-2
"""Share of the boom tip's peak density above which a transmissibility is shown: below, it divides noise by noise."""


def spectrum_lines(record: RunRecord) -> dict[str, Spectrum]:
    """Return the spectra of the evaluation window of the run `record` by name.

    Those that cannot be computed are left out.
    """
    signals = record.signals
    named = {
        "boom tip": signals.boom_tip_heave,
        "uncompensated": signals.uncompensated_heave,
        "unit": signals.unit_heave,
    }
    spectra = {name: spectrum(signal.window(record.start, record.end)) for name, signal in named.items()}
    return {name: found for name, found in spectra.items() if found is not None}


def spectrum_figure(record: RunRecord) -> Figure:
    """Spectra of boom tip and unit, and the transmissibility with and without compensation, of the run `record`."""
    spectra = spectrum_lines(record)
    compared = [name for name in ("uncompensated", "unit") if {name, "boom tip"} <= set(spectra)]
    figure = Figure(
        "Spectra and transmissibility",
        "One-sided spectra over angular frequency (Welch). Transmissibility √(S_load/S_boom tip), "
        "where the boom tip has at least a hundredth of its peak density.",
        layout=_spectrum_layout([(spectra[name], spectra["boom tip"]) for name in compared]),
        is_over_time=False,
        height=560,
    )
    colours = {"boom tip": BOOM_TIP, "uncompensated": UNCOMPENSATED, "unit": UNIT}
    labels = {"unit": "compensated", "uncompensated": "winch locked"}
    for name, found in spectra.items():
        figure.traces.append(_density_line(found, labels.get(name, name), colours[name]))
    for name in compared:
        ratio = transmissibility(spectra[name], spectra["boom tip"], SCALED_FLOOR)
        figure.traces.append(_spectrum_line(ratio, labels.get(name, name), colours[name], axis="y2"))
    return figure


def comparison_of_spectra(records: Sequence[RunRecord], names: Sequence[str]) -> Figure:
    """Spectra and transmissibility of the unit in several runs, `records`, each by its name among `names`."""
    found_of = [spectrum_lines(record) for record in records]
    pairs = [(found["unit"], found["boom tip"]) for found in found_of if {"unit", "boom tip"} <= set(found)]
    figure = Figure(
        "Spectra and transmissibility of all runs",
        "Of the load. Transmissibility where the boom tip has at least a hundredth of its peak density.",
        layout=_spectrum_layout(pairs),
        is_over_time=False,
        height=560,
    )
    for index, (found, label) in enumerate(zip(found_of, names, strict=True)):
        colour = RUN_COLOURS[index % len(RUN_COLOURS)]
        if "unit" in found:
            figure.traces.append(_density_line(found["unit"], label, colour))
        if {"unit", "boom tip"} <= set(found):
            ratio = transmissibility(found["unit"], found["boom tip"], SCALED_FLOOR)
            figure.traces.append(_spectrum_line(ratio, label, colour, axis="y2"))
    return figure


def _spectrum_line(shown: Spectrum, name: str, colour: str, **style: Any) -> dict[str, Any]:
    visible = shown.omega <= HIGHEST_OMEGA
    return line(Signal(shown.omega[visible], shown.density[visible]), name, colour, **style)


def _density_line(shown: Spectrum, name: str, colour: str) -> dict[str, Any]:
    return _spectrum_line(Spectrum(shown.omega, CM**2 * shown.density), name, colour)


def _decades(pairs: Sequence[tuple[Spectrum, Spectrum]]) -> float:
    """Return how many decades the densities that are shown span."""
    shown = [one.density[(one.omega <= SHOWN_OMEGA) & (one.density > 0.0)] for pair in pairs for one in pair]
    values = np.concatenate(shown) if shown else np.empty(0)
    return float(np.log10(values.max() / values.min())) if values.size else 1.0


def _spectrum_layout(pairs: Sequence[tuple[Spectrum, Spectrum]]) -> dict[str, Any]:
    """Return the layout for transmissibilities of `pairs` (unit, boom tip), scaled to what is shown and moves much."""
    ratios = [transmissibility(unit, boom_tip, SCALED_FLOOR) for unit, boom_tip in pairs]
    shown = [ratio.density[ratio.omega <= SHOWN_OMEGA] for ratio in ratios]
    reach = 1.15 * max((float(values.max()) for values in shown if values.size), default=1.0)
    return {
        "xaxis": {"title": {"text": "angular frequency ω [rad/s]"}, "range": [0.0, SHOWN_OMEGA], "anchor": "y2"},
        "yaxis": {
            "title": {"text": "S(ω) [cm² s/rad]"},
            "type": "log",
            "exponentformat": "power",
            "dtick": max(1, math.ceil(_decades(pairs) / 5.0)),
            "domain": [0.54, 1.0],
        },
        "yaxis2": {"title": {"text": "transmissibility [-]"}, "domain": [0.0, 0.46], "range": [0.0, reach]},
    }
