"""A node taken out and another program in its place, in real time; and what the winch does when its controller dies."""

import json
import os
import signal
from pathlib import Path

import numpy as np
import pytest
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag

from tests.loop_runs import HAS_RUN, beside, give, process_of, under_way, wait_until

REAL_WINCH = """
import math
import rclpy
from heave_msgs.msg import WinchCommand, WinchState
from rosgraph_msgs.msg import Clock

class Drive:
    '''A drive with an encoder and nothing of this suite but its messages: follows the payout rate it is told.'''
    def __init__(self, node):
        self.payout = self.rate = self.wanted = 0.0
        self.sequence = 0
        self.state = node.create_publisher(WinchState, "winch/state", 10)
        node.create_subscription(WinchCommand, "winch/command", self.on_command, 10)
        node.create_subscription(Clock, "/clock", self.on_clock, 10)
    def on_command(self, message):
        self.wanted, self.sequence = message.payout_rate, message.sequence
    def on_clock(self, message):
        self.rate += 0.3 * (self.wanted - self.rate)
        self.payout += 0.05 * self.rate
        state = WinchState(command_sequence=self.sequence, payout=math.nan, payout_rate=math.nan)
        state.payout_acceleration = state.tension = math.nan
        state.encoder_payout, state.encoder_payout_rate = self.payout, self.rate
        state.header.stamp = message.clock
        self.state.publish(state)

rclpy.init()
node = rclpy.create_node("drive_17")
drive = Drive(node)
try:
    rclpy.spin(node)
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
"""


@pytest.mark.slow
@pytest.mark.long
def test_a_real_winch_takes_the_place_of_the_virtual_one(tmp_path):
    folder = tmp_path / "run"
    options = ["--pacing", "realtime", "--duration", "30", "--replace", "virtual_winch=external", "--no-report"]
    options += ["--set", "wave_vessel.ramp=5.0"]
    with domain_id() as domain, beside(domain, "-c", REAL_WINCH):
        run = give(domain, "run", "b2_calm_300", "--bag", str(folder), *options)
    assert run.returncode in HAS_RUN, run.stderr
    bag = Bag(folder / "bag")
    winch = bag.columns({"/winch/state": ["encoder_payout", "payout"]})["/winch/state"]
    assert np.isnan(winch["payout"]).all(), "this winch does not know its true payout, and says so"
    assert np.ptp(winch["encoder_payout"]) > 0.01, "the controller moves it"
    unit = bag.columns({"/unit/odometry": ["pose.pose.position.z"]})["/unit/odometry"]
    assert np.isfinite(unit["pose.pose.position.z"]).all()


@pytest.mark.slow
@pytest.mark.long
def test_a_winch_with_a_loop_and_a_clock_of_its_own_compensates(tmp_path):
    """The suite's own drive, 300 ppm fast: commands act after the modelled delay, readings are in time."""
    options = ["--pacing", "realtime", "--duration", "90", "--replace", "virtual_winch=external:own", "--no-report"]
    options += ["--set", "all.transient=40.0", "--set", "wave_vessel.ramp=5.0", "--json", str(tmp_path / "kpi.json")]
    options += ["--set", "winch_controller.modes.settling_time=5.0", "--bag", str(tmp_path / "run")]
    program = Path(__file__).with_name("own_clock_winch.py")
    with domain_id() as domain, beside(domain, str(program), "b2_calm_300"):
        run = give(domain, "run", "b2_calm_300", *options, timeout=300.0)
    assert run.returncode in HAS_RUN, run.stderr
    figures = json.loads((tmp_path / "kpi.json").read_text())
    assert figures["unit_efficiency"] > 0.8
    assert figures["outlet_efficiency"] > 0.7, "the bag's stamps of another clock are read as in the run"


@pytest.mark.slow
def test_the_winch_stops_within_its_limits_and_brakes_when_its_controller_is_killed(tmp_path):
    folder = tmp_path / "run"
    options = ["--pacing", "realtime", "--duration", "1000", "--no-report", "--set", "wave_vessel.ramp=5.0"]
    with domain_id() as domain, under_way(domain, "run", "b2_calm_300", "--bag", str(folder), *options) as run:
        wait_until(lambda: _is_moving(folder / "bag"), 90.0)
        os.kill(process_of("winch_controller", folder), signal.SIGKILL)
        _, err = run.communicate(timeout=60.0)
    assert run.returncode == 1
    assert "winch_controller was killed by SIGKILL" in err.strip().splitlines()[-1]
    assert "virtual_winch: drive: WINCH_COMMAND_TIMEOUT (high)" in err, "told on the terminal as it happens"
    names = ["payout_rate", "payout_acceleration", "fault", "brake"]
    winch = Bag(folder / "bag").columns({"/winch/state": names})["/winch/state"]
    assert winch["fault"][-1] == 1, "FAULT_COMMAND_TIMEOUT"
    assert winch["brake"][-1]
    assert winch["payout_rate"][-1] == 0.0
    assert np.abs(winch["payout_acceleration"]).max() <= 1.5 * (1.0 + 1e-9), "the scenario's acceleration limit"


def _is_moving(bag: Path) -> bool:
    try:
        rates = Bag(bag).columns({"/winch/state": ["payout_rate"]})["/winch/state"]["payout_rate"]
    except Exception:  # the bag is being written: there may be nothing to read yet
        return False
    return bool(np.abs(rates).max(initial=0.0) > 0.02)
