"""How fast the plant is and how wrong, beside MoorDyn on the same system in the same run."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

import numpy as np

from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.peers.driven_run import ramped_sine, run_driven
from cable_sim_node.peers.moordyn import run_moordyn
from cable_sim_node.peers.reference_systems import s900

_PERIOD = 12.0
_TICK = 0.05


def measure_plant(segments_list: Sequence[int] = (20, 50, 100, 200), *, peer: bool = True) -> list[dict[str, float]]:
    """Return for each number of segments: `segments`, `ms_per_simulated_s`, `error_percent`, `ratio_to_moordyn`.

    System of 900 m, boom tip 1 m at 12 s, ticks of 0.05 s as in the loop. Time is processor time, the best of three.
    The error is that of the unit's amplitude against a run with twice the segments and a quarter of the step. The ratio
    is MoorDyn's time over ours: its RK4 at the largest stable step, whose amplitude is as good or better.

    Parameters
    ----------
    segments_list : numbers of segments
    peer : whether MoorDyn runs beside; the ratio is NaN without it, or without the package moordyn
    """
    return [_measure(segments, peer=peer) for segments in segments_list]


def _measure(segments: int, *, peer: bool) -> dict[str, float]:
    own = _cpu_per_second(segments)
    amplitude, refined = _amplitude(segments, 0.05), _amplitude(2 * segments, 0.0125)
    return {
        "segments": segments,
        "ms_per_simulated_s": 1e3 * own,
        "error_percent": 100.0 * abs(amplitude / refined - 1.0),
        "ratio_to_moordyn": _peer_cpu_per_second(segments) / own if peer else math.nan,
    }


def _cpu_per_second(segments: int, duration: float = 30.0) -> float:
    """Return processor seconds per simulated second, the best of three runs from rest."""
    motion = ramped_sine((0.0, 0.0, 1.0), 2.0 * math.pi / _PERIOD, 20.0)
    count = round(duration / _TICK)
    ends = [motion(k * _TICK) for k in range(count + 1)]
    plant = CableDynamics(s900(segments))
    best = math.inf
    for _ in range(3):
        plant.start_at_equilibrium(np.zeros(3))
        plant.advance(_TICK, ends[0], ends[0], 0.0, 0.0, 0.0, 0.0)
        started = time.process_time()
        for k in range(count):
            plant.advance(_TICK, ends[k], ends[k + 1], 0.0, 0.0, 0.0, 0.0)
        best = min(best, (time.process_time() - started) / duration)
    return best


def _amplitude(segments: int, time_step: float) -> float:
    """Return the unit's heave amplitude [m]; what the ramp leaves of free oscillation is the same in all these runs."""
    response = run_driven(
        s900(segments, time_step=time_step),
        (0.0, 0.0, 1.0),
        2.0 * math.pi / _PERIOD,
        duration=300.0,
        window=120.0,
        ramp=150.0,
        tick=_TICK,
    )
    return response.unit_heave_amplitude


def _peer_cpu_per_second(segments: int) -> float:
    """Return MoorDyn's processor seconds per simulated second; NaN without the package."""
    motion = ramped_sine((0.0, 0.0, 1.0), 2.0 * math.pi / _PERIOD, 20.0)
    # enough steps for a steady figure, few enough that 200 segments take a second
    duration = max(10.0, 2000.0 / segments)
    try:
        return run_moordyn(s900(segments), motion, duration=duration, tick=_TICK).cpu_per_second
    except ImportError:
        return math.nan
