"""The controller as a PLC runs it: compiled for another machine, and run in its emulator against a recorded run."""

import math
import shutil
import subprocess
from pathlib import Path

import heave_core
import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_core.law_table import ACT_DONE
from heave_core.watch_table import LoadNews
from heave_fmu.compiled.build import compile_sources, controller_sources
from heave_fmu.compiled.image import leave_out_plans
from winch_controller_node.core.component import ACTED
from winch_controller_node.core.estimation.sense_design import SENSOR
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.interface.sensors import SCALAR_SENSORS

REPLAY = Path(heave_core.__file__).parent / "plc" / "replay.c"
MACHINE, EMULATOR = "aarch64-linux-gnu-", "qemu-aarch64"
AGREEMENT = 1e-12
"""Largest difference of an order [m], [m/s]: the mathematical libraries of two machines differ in the last bit."""
MODES = list(Mode)
LOAD_NEWS = [row.name for row in ACT_DONE.rows].index("load_news")
SETTINGS = (
    *("winch_controller.law=lqg", "all.duration=60", "wave_vessel.mru.faults.kind=[gap]"),
    *("wave_vessel.mru.faults.start=[40.0]", "wave_vessel.mru.faults.duration=[6.0]"),
    *("wave_vessel.mru.faults.magnitude=[0.0]", "cable_sim.sensors.load_cell.faults.kind=[jump]"),
    *("cable_sim.sensors.load_cell.faults.start=[52.0]", "cable_sim.sensors.load_cell.faults.duration=[4.0]"),
    "cable_sim.sensors.load_cell.faults.magnitude=[2e5]",
)
"""The MRU is silent for some seconds; later the load cell reads 200 kN too much."""


def recorded(parameters):
    """Return a run without adviser as the replay reads it, and the orders of its controller, shape (ticks, 6)."""
    loop = ClosedLoop(parameters, has_adviser=False)
    leave_out_plans(loop.controller)  # as the export has it
    step = loop.controller.step
    numbers, orders = [], []

    def noted(tick, raw):
        mru = SENSOR["mru"]
        rows = [
            (mru, one.time, one.heave, one.heave_rate, one.roll, one.pitch, one.status, *one[-2:]) for one in raw.mru
        ]
        rows += [
            (SENSOR[name], *one, 0.0, 0.0, 0.0, 0.0, math.nan, math.nan)
            for name in SCALAR_SENSORS
            for one in raw.of(name)
        ]
        winch, outputs = raw.winch, step(tick, raw)
        numbers.extend((len(rows), *(number for row in rows for number in row)))
        reported = (0.0,) * 8 if winch is None else (1.0, *winch[:5], winch.limits_hit, winch.command_sequence)
        numbers.extend(reported)
        order = outputs.order
        mode, load_news = MODES.index(Mode(outputs.mode)), loop.controller._control.done[ACTED + LOAD_NEWS]
        orders.append((order.payout, order.payout_rate, order.brake, mode, outputs.authority, load_news))
        return outputs

    loop.controller.step = noted
    loop.run()
    return np.array(numbers, float), np.array(orders, float)


def test_orders_in_an_emulator_are_those_of_the_recorded_run(tmp_path, monkeypatch):
    for needed in (f"{MACHINE}g++", EMULATOR):
        if shutil.which(needed) is None:
            pytest.skip(f"{needed} is not installed: Debian's packages g++-aarch64-linux-gnu and qemu-user")
    parameters = loop_parameters(load_scenario("b2_calm_300", settings=SETTINGS))
    sources = tmp_path / "sources"
    sources.mkdir()
    for name, text in (controller_sources(parameters) | {REPLAY.name: REPLAY.read_text()}).items():
        (sources / name).write_text(text)
    monkeypatch.setenv("CC", f"{MACHINE}gcc")
    monkeypatch.setenv("CXX", f"{MACHINE}g++")
    compile_sources(sources, tmp_path / "replay", "-static")
    run, wanted = recorded(parameters)
    run.tofile(tmp_path / "run")
    subprocess.run([EMULATOR, tmp_path / "replay", tmp_path / "run", tmp_path / "orders"], check=True, timeout=300)
    found = np.fromfile(tmp_path / "orders").reshape(wanted.shape)
    assert {MODES[int(mode)] for mode in wanted[:, 3]} >= {Mode.STANDBY, Mode.COMPENSATING, Mode.FADE_OUT}
    assert np.std(wanted[:, 1]) > 0.05
    assert int(LoadNews.TENSION_HIGH) in wanted[:, 5]
    np.testing.assert_array_equal(found[:, [2, 3, 5]], wanted[:, [2, 3, 5]])
    np.testing.assert_allclose(found, wanted, 0.0, AGREEMENT)
