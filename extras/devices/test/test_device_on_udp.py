"""A motion sensor and a load cell that know nothing of the suite but are on UDP, and the suite's controller on them."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag

from extras.devices.test.udp_ship import AMPLITUDE, PERIOD
from tests.loop_runs import adapting, give
from tests.plc import free_port

MRU_MAP = """
source: {{udp: {port}}}
format: nmea
clock: own
heave: PNORSUB2.heave
heave_rate: PNORSUB2.heave_rate
roll: PNORSUB2.roll
pitch: PNORSUB2.pitch
"""
CELL_MAP = """
source: {{udp: {port}}}
format: line
pattern: '(?P<covered>RD,(?P<tension>[-0-9.]+),[-0-9.]+,[-0-9.]+,)(?P<checksum>\\d{{4}})$'
checksum: sum
tension: {{field: tension, unit: kN, sigma: 200.0}}
"""


@pytest.mark.slow
def test_the_loop_compensates_by_a_motion_sensor_and_a_load_cell_on_udp(tmp_path):
    """99 m that the sensor calls invalid, and 90 m with a wrong checksum, come every ten seconds."""
    ports = free_port("udp"), free_port("udp")
    maps = []
    for name, text, port in (("sensor", MRU_MAP, ports[0]), ("cell", CELL_MAP, ports[1])):
        maps.append(str(tmp_path / f"{name}.yaml"))
        Path(maps[-1]).write_text(text.format(port=port))
    options = [
        "--pacing",
        "realtime",
        "--duration",
        "45",
        "--replace",
        "wave_vessel=external",
        "--replace",
        "cable_sim=external",
    ]
    options += ["--set", "all.transient=30", "--set", "winch_controller.modes.settling_time=5.0", "--no-report"]
    with domain_id() as domain:
        ship = subprocess.Popen([sys.executable, str(Path(__file__).with_name("udp_ship.py")), *map(str, ports)])
        try:
            with adapting(domain, *maps, "--json", str(tmp_path / "adapter.json")) as ended:
                run = give(domain, "run", "b2_calm_300", "--bag", str(tmp_path / "run"), *options, timeout=180.0)
        finally:
            ship.kill()
            ship.wait()
    (adapter,) = ended
    assert run.returncode == 0, run.stdout + run.stderr + adapter.err
    assert adapter.returncode == 0, adapter.err
    columns = Bag(tmp_path / "run" / "bag").columns(
        {"/mru": ["heave", "heave_rate", "status"], "/winch/load_cell": ["tension"], "/winch/state": ["encoder_payout"]}
    )
    good = columns["/mru"]["status"] == 0
    assert np.abs(columns["/mru"]["heave"][good]).max() == pytest.approx(AMPLITUDE, rel=0.01)
    assert np.isnan(columns["/mru"]["heave"][~good]).all()
    assert (~good).sum() >= 2
    assert columns["/winch/load_cell"]["tension"].mean() == pytest.approx(25e3, rel=0.02)
    # the payout follows the swell: sigma of a sine is its amplitude over the root of two
    last = columns["/winch/state"]["encoder_payout"][-round(2.0 * PERIOD / 0.05) :]
    assert last.std() == pytest.approx(AMPLITUDE / np.sqrt(2.0), rel=0.1)
    figures = json.loads((tmp_path / "adapter.json").read_text())
    assert figures["sensor"]["checksum_errors"] >= 2
    assert figures["sensor"]["invalid"] >= 2
    assert figures["cell"]["checksum_errors"] == 0
    assert "readings" in adapter.out


@pytest.mark.long
def test_a_load_cell_alone_takes_the_place_of_the_simulated_one_and_the_truth_stays(tmp_path):
    port = free_port("udp")
    cell = tmp_path / "cell.yaml"
    cell.write_text(CELL_MAP.format(port=port))
    options = ["--pacing", "realtime", "--duration", "45", "--replace", "winch/load_cell=external", "--no-report"]
    options += ["--set", "all.transient=30", "--set", "winch_controller.modes.settling_time=5.0"]
    with domain_id() as domain:
        program = str(Path(__file__).with_name("udp_ship.py"))
        ship = subprocess.Popen([sys.executable, program, str(free_port("udp")), str(port)])
        try:
            with adapting(domain, str(cell)):
                run = give(domain, "run", "b2_calm_300", "--bag", str(tmp_path / "run"), *options, timeout=180.0)
        finally:
            ship.kill()
            ship.wait()
    assert run.returncode == 0, run.stdout + run.stderr
    columns = Bag(tmp_path / "run" / "bag").columns({"/winch/load_cell": ["tension"], "/cable/state": ["top_tension"]})
    tension = columns["/winch/load_cell"]["tension"]
    assert len(tension) > 300, "ten a second for 45 s"
    # 25 kN is what udp_ship.py sends; the simulated cell reads the weight of another unit
    assert tension == pytest.approx(25e3, rel=0.1)
    assert len(columns["/cable/state"]["top_tension"]) > 100
