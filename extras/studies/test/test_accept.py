"""Acceptance tests of real parts, and of records of somebody else: what should pass passes, what should not fails.

The winch behind Modbus/TCP is a program of its own; the published controllers are integrated here from their equations.
"""

import json
import os
import time
from pathlib import Path

import numpy as np
import pytest
from domain_coordinator import domain_id
from heave_bringup.cli import main
from heave_devices.adapt.device import LiveDevice
from heave_devices.bench.real_winch import RealPart
from heave_devices.bench.winch import run_winch
from heave_devices.maps.device_map import device_map_of
from heave_node.files.bounded_yaml import parse_yaml
from heave_studies.accept import measured as figures
from heave_studies.accept.measured import Nominal, of_winch
from heave_studies.accept.procedure import Limits, read_head, read_procedure
from heave_studies.study.study_file import find_study
from scipy.interpolate import CubicSpline
from scipy.signal import lsim

from tests.adapt_fakes import Node
from tests.loop_runs import give
from tests.plc import emulated

RECORDS = Path(os.environ.get("HEAVE_BENCHMARK_RECORDS", Path(__file__).parents[3] / "shared" / "data" / "published"))
needs_records = pytest.mark.skipif(
    not (RECORDS / "zinage_moderate.csv").is_file(), reason="HEAVE_BENCHMARK_RECORDS names no folder of the records"
)
NOMINAL = Nominal(2.0, 1.5, 0.35)


def winch_steps(*names):
    """Return steps of the shipped factory test, all of them without names."""
    steps = read_procedure(read_head(find_study("winch_factory_test")), Limits(2.0, 1.5)).steps
    return [step for step in steps if not names or step.name in names]


def failing(steps, *options):
    """Return which of the steps an emulated winch fails; a person's part is played by its drive's own trip."""
    with emulated("modbus", *options) as plc:
        device = LiveDevice(device_map_of("winch", parse_yaml(plc.text_of_map())), Node())
        device.start()
        try:
            found, part = set(), RealPart(device, time.sleep, lambda _: plc.tell("trip"))
            for step in steps:
                trace = run_winch(part, step.test, step.event, step.name, lambda *_: None)
                values = figures.evaluate(of_winch(trace, step.test, NOMINAL), step.alarms)
                judged = [figures.judged(one, values) for one in step.wanted]
                found |= {step.name for one in judged if not one.is_met}
            return found
        finally:
            device.close()


@pytest.mark.long
def test_an_emulated_winch_behind_modbus_passes_its_factory_test():
    assert failing(winch_steps()) == set()


@pytest.mark.long
def test_an_emulated_winch_that_is_a_fifth_too_slow_fails_at_full_speed():
    slow = failing(winch_steps("Full speed", "Steps", "Loss of commands", "Loss of power"), "--speed", "1.6")
    assert slow == {"Full speed"}


def loop_of(law):
    """Return A, B, C, D from heave to the error -heave - z of a published loop (Zinage & Somayajula 2020)."""
    a, b = np.zeros((4, 4)), np.array([1.0, 0.0, 0.0, 0.0])
    a[0, 0] = -1.0
    a[1, 0], a[1, 2] = -2.0 * 1.8e9 / 2e-3 * 40e-6 * 45.0, 2.0 * 1.8e9 / 2e-3 * 4e-6 * 200.0 / 0.5
    a[2, 1], a[2, 2] = -0.5 * 4e-6 * 200.0 * 0.65 / 400.0, -1e4 / 400.0
    a[3, 2] = 1.0
    full, drive = np.zeros((6, 6)), np.zeros(6)
    full[:4, :4] = a
    full[4, 3], drive[4] = -1.0, -1.0  # the integral of e = -heave - z
    if law == "pid":  # u = 5.86 e + 0.711 int e + 5.46 N (e - f), f' = N (e - f)
        n, gain = 33.33, 5.86 + 5.46 * 33.33
        full[5, 3], full[5, 5], drive[5] = -n, -n, -n
        full[0, 3], full[0, 4], full[0, 5], drive[0] = -gain, 0.711, -5.46 * n, -gain
    else:
        full[0, :4] -= np.array([814.229012, -1.02561303e-4, 1260.27957, 61238.9087]) * b[0]
        full[0, 4] += 316227.766
        full[5, 5] = -1.0
    return full, drive[:, None], np.array([[0.0, 0.0, 0.0, -1.0, 0.0, 0.0]]), np.array([[-1.0]])


def foreign_log(folder, sea, law):
    """Write what the published loop did, as its maker might have logged it: cm, rope reeled in positive."""
    record = np.loadtxt(RECORDS / f"zinage_{sea}.csv", delimiter=",", skiprows=1)
    time = np.arange(0.0, 500.0, 0.005)
    heave = CubicSpline(record[:, 0], record[:, 1])(time)
    _, error, _ = lsim(loop_of(law), heave, time)
    reeled = -heave - error
    table = np.column_stack((time, 100.0 * heave, 100.0 * reeled))[::10]
    np.savetxt(folder / "log.csv", table, fmt="%.4f", delimiter=",", header="t,ship,rope", comments="")
    (folder / "map.yaml").write_text(
        "time_column: t\nheave: {column: ship, unit: cm}\npayout: {column: rope, unit: cm, positive: in}\n"
    )


TRIAL = """title: Residual of a published controller
scenario: b2_calm_300
steps:
  - name: residual
    record: {from: 100 s, to: 500 s}
    wanted: {outlet_sigma_m: "<= BOUND cm"}
"""


@needs_records
@pytest.mark.parametrize(
    ("sea", "law", "published", "bound", "status"),
    [
        ("moderate", "pid", 2.740, 3.0, 0),
        ("moderate", "lqi", 3.177, 3.0, 3),
        ("rough", "pid", 7.197, 7.5, 0),
        ("rough", "lqi", 8.264, 7.5, 3),
    ],
)
def test_records_of_published_controllers_pass_and_fail_where_they_should(
    sea, law, published, bound, status, tmp_path, capsys
):
    foreign_log(tmp_path, sea, law)
    (tmp_path / "trial.yaml").write_text(TRIAL.replace("BOUND", f"{bound:g}"))
    record = ["--ask", f"record={tmp_path / 'log.csv'}", "--ask", f"map={tmp_path / 'map.yaml'}"]
    result = tmp_path / "result.json"
    where = ["--output", str(tmp_path / "out"), "--json", str(result)]
    assert main(["study", str(tmp_path / "trial.yaml"), *record, *where]) == status
    (criterion,) = json.loads(result.read_text())["steps"][0]["criteria"]
    assert 100.0 * criterion["got"] == pytest.approx(published, rel=0.01), "computed anew from the papers, 1 ms steps"
    capsys.readouterr()


@pytest.mark.long
@pytest.mark.parametrize("procedure", ["sensor_check", "harbour_test", "sea_trial"])
def test_the_virtual_parts_pass_the_shipped_trials(procedure, tmp_path):
    with domain_id() as domain:
        done = give(domain, "study", procedure, "--output", str(tmp_path / "out"), timeout=900.0)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "out" / "page.html").is_file()
