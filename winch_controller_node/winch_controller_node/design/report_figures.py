"""Figures of the design report, one matplotlib figure each."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from winch_controller_node.design.report import DesignReport, TradeOff, knee

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_report(report: DesignReport, folder: Path) -> list[Path]:
    """Draw all figures of a `report` into `folder` (made if missing) as SVG; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name, figure in report_figures(report).items():
        path = folder / f"design_{name}.svg"
        figure.savefig(path, metadata={"Date": None})
        files.append(path)
    return files


def report_figures(report: DesignReport) -> dict[str, Figure]:
    """Return the figures of a `report` by name: poles, loop, weight, winch."""
    return {
        "poles": _poles(report),
        "loop": _loop(report),
        "weight": _trade_off(
            report.weight_curve,
            "Trade-off against the command scale (thesis figs 6.18, 6.19)",
            "predicted payout acceleration, 1 sigma [m/s²]",
            lambda point: point.acceleration_sigma,
        ),
        "winch": _winch(report),
    }


def _figure(title: str) -> tuple[Figure, Axes]:
    from matplotlib.figure import Figure  # noqa: PLC0415  # heavy, and only for who draws

    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    axes = figure.add_subplot()
    axes.set_title(title)
    axes.grid(visible=True, alpha=0.3)
    return figure, axes


def _poles(report: DesignReport) -> Figure:
    figure, axes = _figure("Closed-loop poles, unit circle is the edge of stability")
    angle = np.linspace(0.0, 2.0 * math.pi, 400)
    axes.plot(np.cos(angle), np.sin(angle), color="0.6", linewidth=0.8)
    axes.plot(report.poles.real, report.poles.imag, "x")
    axes.set_aspect("equal")
    axes.set_xlabel("real part [-]")
    axes.set_ylabel("imaginary part [-]")
    return figure


def _loop(report: DesignReport) -> Figure:
    margin = report.margins_output
    figure, axes = _figure(
        f"Loop at the command: sensitivity peak {margin.sensitivity_peak:.2f}, delay margin {margin.delay:.2f} s"
    )
    axes.loglog(report.omegas, np.abs(report.loop), label="loop gain |L|")
    axes.loglog(report.omegas, 1.0 / np.abs(1.0 + report.loop), label="sensitivity |1/(1+L)|")
    axes.axhline(1.0, color="0.6", linewidth=0.8)
    axes.set_xlabel("angular frequency [rad/s]")
    axes.set_ylabel("magnitude [-]")
    axes.legend()
    return figure


def _trade_off(curve: tuple[TradeOff, ...], title: str, label: str, use: object) -> Figure:
    figure, axes = _figure(title)
    assert callable(use)
    axes.loglog([use(point) for point in curve], [100.0 * point.unit_sigma for point in curve], "o-")
    for point in curve:
        axes.annotate(f"{point.parameter:g}", (use(point), 100.0 * point.unit_sigma), fontsize=8)
    axes.set_xlabel(label)
    axes.set_ylabel("predicted unit heave, 1 sigma [cm]")
    return figure


def _winch(report: DesignReport) -> Figure:
    figure, axes = _figure("Command for one unit heave against the lag of the winch (thesis fig 6.25)")
    curve = report.winch_curve
    axes.semilogx([point.parameter for point in curve], [point.command_sigma for point in curve], "o-", label="command")
    if curve:
        axes.axvline(knee(curve), color="0.6", linestyle="--", label="knee: quicker saves less than 10 %")
    axes.set_xlabel("lag of the winch, T or 1/K [s]")
    axes.set_ylabel("command, 1 sigma [m/s; m for a first-order winch]")
    axes.legend()
    return figure
