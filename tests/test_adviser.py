"""The adviser beside the loop: in lockstep it is waited for, in real time never, and the run goes on without it."""

import json
import os
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag
from rclpy.serialization import deserialize_message

from tests.loop_runs import (
    CALM_DURATION,
    beside,
    command,
    environment,
    give,
    heave,
    process_of,
    recorded_messages,
    under_way,
    wait_until,
)

PROGRAM = Path(__file__).with_name("adviser_program.py")
REAL_TIME = ("--pacing", "realtime")
CALM = ("run", "b2_calm_300", "--no-report")


def adviser_part(bag):
    """Return what the controller said last of its adviser: level, words, counts."""
    parts = [
        part
        for message in Bag(bag).messages(["/diagnostics"])
        for part in deserialize_message(message.data, DiagnosticArray).status
        if part.name == "winch_controller: adviser"
    ]
    values = {value.key: int(value.value) for value in parts[-1].values}
    return parts[-1].level, parts[-1].message, values


def test_each_batch_of_a_lockstep_run_is_answered_in_time(calm_bag):
    """A batch a second makes ten in ten seconds; the last is over when the run is, and gets no answer."""
    bag = Bag(calm_bag)
    observed = bag.columns({"/controller/observations": ["first"]})["/controller/observations"]["first"]
    asked = bag.columns({"/controller/beliefs": ["asked"]})["/controller/beliefs"]["asked"]
    assert list(observed) == [20 * batch + 1 for batch in range(round(CALM_DURATION))]
    assert list(asked) == [20 * batch for batch in range(1, round(CALM_DURATION))]
    level, words, values = adviser_part(calm_bag)
    assert (level, values["late"], values["malformed"]) == (DiagnosticStatus.OK, 0, 0)
    assert words.startswith("in time")


def test_how_long_the_adviser_takes_is_not_in_a_lockstep_bag(tmp_path, calm_bag):
    folder = tmp_path / "run"
    with domain_id() as domain, beside(domain, str(PROGRAM), "0.0", "0.4"):
        run = give(
            domain, *CALM, "--duration", str(CALM_DURATION), "--bag", str(folder), "--replace", "winch_adviser=lockstep"
        )
    assert run.returncode == 0, run.stderr
    assert recorded_messages(folder / "bag") == recorded_messages(calm_bag)


def test_an_adviser_that_does_not_answer_in_lockstep_is_named_and_ends_the_run(tmp_path):
    options = ("--replace", "winch_adviser=lockstep", "--set", "all.participant_timeout=3")
    with domain_id() as domain, beside(domain, str(PROGRAM), "60.0", "60.0") as program:
        run = give(domain, *CALM, "--duration", "100", "--bag", str(tmp_path / "run"), *options)
        program.kill()
    assert run.returncode == 1
    assert "winch_adviser has not finished tick" in run.stderr.strip().splitlines()[-1]
    assert Bag(tmp_path / "run" / "bag").message_count > 0


def test_the_answers_of_a_run_are_given_again_bit_for_bit(calm_bag):
    same = heave("replay", str(calm_bag), "--adviser")
    assert (same.returncode, same.stderr) == (0, "")
    answers = round(CALM_DURATION) - 1
    assert same.stdout.strip().endswith(f"{answers} answers equal the recorded beliefs, bit for bit; 1 not recorded")


def test_a_run_without_the_adviser_keeps_the_nominal_and_says_nothing_of_it(tmp_path):
    folder = tmp_path / "run"
    run = heave(*CALM, "--duration", "3", "--bag", str(folder), "--replace", "winch_adviser=none", "--composed")
    assert run.returncode == 0, run.stderr
    bag = Bag(folder / "bag")
    assert "/controller/beliefs" not in bag.topics
    assert bag.topics["/controller/observations"].message_count == 3
    assert not [m for m in bag.messages(["/diagnostics"]) if b"winch_controller: adviser" in m.data]
    again = heave("replay", str(folder), "--adviser")
    assert again.returncode == 1
    assert "no messages on controller/beliefs: record a run with winch_adviser" in again.stderr


def test_no_other_node_can_be_left_out():
    run = heave(*CALM, "--replace", "virtual_winch=none")
    assert run.returncode == 2
    assert run.stderr.startswith("heave: --replace virtual_winch=none: NODE must be winch_adviser")


@pytest.mark.slow
def test_in_real_time_a_slow_adviser_holds_nothing_up_and_its_late_answers_are_refused_and_counted(tmp_path):
    """An answer takes 1.5 s, and 1 s is allowed."""
    folder = tmp_path / "run"
    with domain_id() as domain, beside(domain, str(PROGRAM), "1.5", "1.5"):
        options = ("--duration", "12", "--replace", "winch_adviser=lockstep", *REAL_TIME)
        run = give(domain, *CALM, *options, "--bag", str(folder))
    assert run.returncode == 0, run.stderr
    assert "ADVISER_LOST (low)" in run.stdout + run.stderr
    level, words, values = adviser_part(folder / "bag")
    assert level == DiagnosticStatus.WARN
    assert words.startswith("late: ")
    assert values["late"] >= 1
    assert values["answered"] == 0


@pytest.mark.slow
def test_in_real_time_a_run_goes_on_without_an_adviser_that_was_killed_and_says_so(tmp_path):
    folder = tmp_path / "run"
    arguments = (*CALM, "--duration", "20", "--bag", str(folder), *REAL_TIME)
    with domain_id() as domain, under_way(domain, *arguments) as run:
        wait_until(lambda: any(f.stat().st_size > 100_000 for f in (folder / "bag").glob("*.mcap")), 60.0)
        os.kill(process_of("winch_adviser", folder), signal.SIGKILL)
        out, err = run.communicate(timeout=90.0)
    assert run.returncode == 0, err
    assert "winch_adviser was killed by SIGKILL: the run continues without it" in out + err
    assert "ADVISER_LOST (medium): no answer for 3." in out + err
    level, words, _ = adviser_part(folder / "bag")
    assert level == DiagnosticStatus.WARN
    assert words.startswith("silent: ")
    assert Bag(folder / "bag").duration == pytest.approx(20.0, abs=0.5)


@pytest.mark.slow
def test_in_real_time_an_adviser_in_the_process_of_the_ticks_works_in_another(tmp_path):
    folder = tmp_path / "run"
    run = heave(*CALM, "--duration", "8", "--composed", *REAL_TIME, "--bag", str(folder))
    assert run.returncode == 0, run.stderr
    assert Bag(folder / "bag").topics["/controller/beliefs"].message_count >= 6
    level, _, values = adviser_part(folder / "bag")
    assert (level, values["malformed"]) == (DiagnosticStatus.OK, 0)
    assert values["answered"] > 4
    again = heave("replay", str(folder), "--adviser", "--json", "-")
    assert json.loads(again.stdout)["different"] == []
    times = Bag(folder / "bag").columns({"/controller/state": ["execution_time"]})["/controller/state"][
        "execution_time"
    ]
    assert np.all(times > 0.0), "in real time each tick says how long it took"


def test_a_lockstep_bag_says_nothing_of_the_machine(calm_bag):
    times = Bag(calm_bag).columns({"/controller/state": ["execution_time"]})["/controller/state"]["execution_time"]
    assert times.size > 0
    assert np.all(np.isnan(times))


ROGUE = """
import time
import rclpy
from heave_msgs.msg import Beliefs
from heave_node.ros.transport.environment import prepare_environment
prepare_environment()
rclpy.init()
node = rclpy.create_node("rogue_adviser")
publisher = node.create_publisher(Beliefs, "controller/beliefs", 10)
while not node.count_subscribers("controller/beliefs"):
    time.sleep(0.1)
tick = 0
try:
    while True:
        tick += 20
        message = Beliefs(asked=tick, number=999, authority=0.0)
        message.header.stamp.sec = tick // 20
        publisher.publish(message)
        time.sleep(0.2)
except KeyboardInterrupt:
    pass
"""


@pytest.mark.slow
def test_beliefs_of_a_stranger_are_not_taken_and_fail_the_run(tmp_path):
    folder = tmp_path / "run"
    with domain_id() as domain, beside(domain, "-c", ROGUE) as rogue:
        run = give(domain, *CALM, *REAL_TIME, "--duration", "12", "--bag", str(folder))
    assert run.returncode == 1, run.stdout + run.stderr
    named = f"/rogue_adviser (process {rogue.pid} on this machine) publishes on /controller/beliefs"
    assert f"winch_controller: strangers: UNKNOWN_PUBLISHER (high): {named}" in run.stderr
    bag = Bag(folder / "bag")
    assert max(bag.columns({"/controller/beliefs": ["number"]})["/controller/beliefs"]["number"]) < 999
    assert "set 999" not in adviser_part(folder / "bag")[1]


@pytest.mark.slow
def test_an_external_adviser_need_not_be_there(tmp_path):
    folder = tmp_path / "run"
    run = heave(*CALM, "--duration", "6", "--replace", "winch_adviser=external", *REAL_TIME, "--bag", str(folder))
    assert run.returncode == 0, run.stderr
    assert "ADVISER_LOST (medium)" in run.stdout + run.stderr
    assert adviser_part(folder / "bag")[0] == DiagnosticStatus.WARN


@pytest.mark.slow
def test_in_real_time_a_redesign_is_made_in_another_process_and_the_adviser_is_told_what_was_restated(tmp_path):
    folder = tmp_path / "run"
    with domain_id() as domain:
        run = subprocess.Popen(
            command(*CALM, "--duration", "300", "--bag", str(folder), *REAL_TIME),
            env=environment(domain),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            wait_until(lambda: any(f.stat().st_size > 100_000 for f in (folder / "bag").glob("*.mcap")), 60.0)
            asked = give(domain, "operate", "redesign", "--height", "2", "--period", "9")
            wait_until(lambda: restated(folder / "bag")[-1] != {}, 60.0)
        finally:
            run.send_signal(signal.SIGINT)
            run.wait(60.0)
    assert asked.returncode == 0, asked.stderr
    assert "predicted unit heave" in asked.stdout
    found = restated(folder / "bag")
    assert found[0] == {}
    assert found[-1] == {"sea.significant_wave_height": 2.0, "sea.peak_period": 9.0}


def restated(bag):
    """Return in each batch of a bag, which may still grow, what an operator has restated, by name."""
    batches = (content for _, content in Bag(bag).decoded(["/controller/observations"]))
    return [dict(zip(batch.restated, batch.restated_values, strict=True)) for batch in batches]
