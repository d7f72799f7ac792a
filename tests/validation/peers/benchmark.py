"""How fast the plant is and how wrong, beside MoorDyn on the same system, driven the same way, in the same run."""

from __future__ import annotations

import importlib.util
import math
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableSimParameters
from heave_node.numerics.kinematics import PointMotion

from tests.validation.peers.driven_run import first_harmonic, ramped_sine, run_driven
from tests.validation.peers.moordyn import SETTINGS, PeerRun, Setting, run_moordyn
from tests.validation.peers.reference_systems import s900

_PERIOD = 12.0
_TICK = 0.05
_ROUNDS = 6
_LONGEST, _SHORTEST = 10.0, 2.0
"""Simulated time that is timed [s]: less of it with many segments, which a peer takes seconds for."""
_RECORD, _WINDOW, _LONG_RAMP = 300.0, 120.0, 150.0
"""A run for its amplitude: its length, the part at its end that is analysed, the ramp at its start [s]."""
_MOST_FOR_ERROR = 200
"""Segments beyond which the error of a peer is not measured: it would take minutes."""

Motion = Callable[[float], PointMotion]


def measure_plant(segments_list: Sequence[int] = (20, 50, 100, 200), *, peer: bool = True) -> list[dict[str, Any]]:
    """Return `segments`, `ms_per_simulated_s`, `error_percent`, `peers` and `ratio_to_moordyn` for each number of them.

    System of 900 m, boom tip 1 m at 12 s, from rest; unit position and top tension are read every 0.05 s from both,
    as in the loop. Time is processor time, the best of six runs of each contender; they take turns, so that a busy
    machine is busy for all. The error
    is that of the unit's amplitude against a run of the plant with twice the segments and a quarter of the step.
    `peers` holds both for each setting of MoorDyn, by its name, at its largest stable step, the error up to 200
    segments and NaN beyond; the ratio is its fastest time over ours.

    Parameters
    ----------
    segments_list : numbers of segments
    peer : whether MoorDyn runs beside; without it, or without the package moordyn, there are no peers, and the ratio is
        NaN
    """
    settings = SETTINGS if peer and importlib.util.find_spec("moordyn") is not None else ()
    return [_measure(segments, settings) for segments in segments_list]


def _measure(segments: int, settings: Sequence[Setting]) -> dict[str, Any]:
    own, *times = _milliseconds(segments, settings)
    refined = _amplitude(s900(2 * segments, time_step=0.0125))
    peers = {
        setting.name: {"ms_per_simulated_s": ms, "error_percent": _error(_peer_amplitude(segments, setting), refined)}
        for setting, ms in zip(settings, times, strict=True)
    }
    return {
        "segments": segments,
        "ms_per_simulated_s": own,
        "error_percent": _error(_amplitude(s900(segments)), refined),
        "peers": peers,
        "ratio_to_moordyn": min(times, default=math.nan) / own,
    }


def _milliseconds(segments: int, settings: Sequence[Setting]) -> list[float]:
    """Return the processor time per simulated second of the plant and of MoorDyn under each setting [ms]."""
    duration = min(max(_SHORTEST, 1000.0 / segments), _LONGEST)
    motion = ramped_sine((0.0, 0.0, 1.0), 2.0 * math.pi / _PERIOD, 20.0)
    best = [math.inf] * (1 + len(settings))
    for _ in range(_ROUNDS):
        used = [_cpu_per_second(segments, motion, duration)]
        used += [_run_peer(segments, motion, duration, setting).cpu_per_second for setting in settings]
        best = [min(pair) for pair in zip(best, used, strict=True)]
    return [1e3 * seconds for seconds in best]


def _cpu_per_second(segments: int, motion: Motion, duration: float) -> float:
    plant = CableDynamics(s900(segments))
    plant.start_at_equilibrium(np.zeros(3))
    count = round(duration / _TICK)
    ends = [motion(k * _TICK) for k in range(count + 1)]
    plant.advance(_TICK, ends[0], ends[0], 0.0, 0.0, 0.0, 0.0)
    started = time.process_time()
    for k in range(count):
        plant.advance(_TICK, ends[k], ends[k + 1], 0.0, 0.0, 0.0, 0.0)
        _ = plant.unit_position, plant.top_tension
    return (time.process_time() - started) / duration


def _run_peer(segments: int, motion: Motion, duration: float, setting: Setting) -> PeerRun:
    return run_moordyn(s900(segments), motion, duration=duration, tick=_TICK, setting=setting)


def _amplitude(parameters: CableSimParameters) -> float:
    """Return the unit's heave amplitude [m]; what the ramp leaves of free oscillation is the same in all these runs."""
    frequency = 2.0 * math.pi / _PERIOD
    record = {"duration": _RECORD, "window": _WINDOW, "ramp": _LONG_RAMP, "tick": _TICK}
    return run_driven(parameters, (0.0, 0.0, 1.0), frequency, **record).unit_heave_amplitude


def _peer_amplitude(segments: int, setting: Setting) -> float:
    if segments > _MOST_FOR_ERROR:
        return math.nan
    frequency = 2.0 * math.pi / _PERIOD
    run = _run_peer(segments, ramped_sine((0.0, 0.0, 1.0), frequency, _LONG_RAMP), _RECORD, setting)
    last = run.times > _RECORD - _WINDOW
    return first_harmonic(run.times[last], run.unit[last, 2], frequency)[1]


def _error(amplitude: float, refined: float) -> float:
    return 100.0 * abs(amplitude / refined - 1.0)
