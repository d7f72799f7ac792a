"""Acceptance tests of real parts: what should pass passes, what should not fails.

The winch behind Modbus/TCP is a program of its own.
"""

import time

import pytest
from domain_coordinator import domain_id
from heave_devices.adapt.device import LiveDevice
from heave_devices.bench.real_winch import RealPart
from heave_devices.bench.winch import run_winch
from heave_devices.maps.device_map import device_map_of
from heave_node.files.bounded_yaml import parse_yaml
from heave_studies.accept import measured as figures
from heave_studies.accept.measured import Nominal, of_winch
from heave_studies.accept.procedure import Limits, read_head, read_procedure
from heave_studies.study.study_file import find_study

from tests.adapt_fakes import Node
from tests.loop_runs import give
from tests.plc import emulated

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


@pytest.mark.long
@pytest.mark.parametrize("procedure", ["sensor_check", "harbour_test", "sea_trial"])
def test_the_virtual_parts_pass_the_shipped_trials(procedure, tmp_path):
    with domain_id() as domain:
        done = give(domain, "study", procedure, "--output", str(tmp_path / "out"), timeout=900.0)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "out" / "page.html").is_file()
