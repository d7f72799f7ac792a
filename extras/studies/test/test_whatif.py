"""`heave whatif`: only sensors are read, the same law gives it again, what cannot carry an answer is refused."""

import contextlib
import math
import os
import random
import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from heave_bags.mcap.bag_writer import Attachment, BagWriter
from heave_bags.mcap.reader import LOG_TIME, TIME, Bag
from heave_bringup.errors import CommandError
from heave_bringup.scenarios import load_scenario
from heave_msgs.msg import WinchState
from heave_node.interface.sensors import WireReading
from heave_studies.study.workers import workers
from heave_studies.whatif import fitness
from heave_studies.whatif.answer import answers, learn
from heave_studies.whatif.record import (
    SELECTION,
    Gate,
    Loss,
    delivered,
    first_request,
    read_record,
    stored_scenario,
)
from heave_studies.whatif.twin import Asked, observed_again
from rclpy.serialization import deserialize_message, serialize_message
from winch_controller_node.core.component import WinchController
from winch_controller_node.interface.readings import Measurements

from tests.campaigns import whatif as campaign
from tests.campaigns.in_process import heave, judge
from tests.campaigns.whatif import Draw, Recording, make_draw, run_draw, scenario_of
from tests.loop_runs import run_scenario

TRUE_FIELDS = ("payout", "payout_rate", "payout_acceleration", "tension", "power")
"""Fields of winch/state that only a simulator knows."""

TICK = 50_000_000
"""Tick period of the runs [ns]."""


def without_truth(bag, folder, *, topics=tuple(SELECTION), logged=lambda topic, time: time, **run):
    """Write a bag with the `topics` alone, and with no truth in winch/state; return it.

    Parameters
    ----------
    bag, folder : the bag, and where it is written
    topics : that are kept
    logged : returns when a message on a topic is recorded that was recorded at a time [ns]; None: it is lost
    run : words about the run that are other
    """
    attachments = [Attachment(name, found.media_type, found.data) for name, found in bag.attached.items()]
    writer = BagWriter(folder, run={**bag.run, **run}, attachments=attachments)
    kept = [name for name in bag.topics if name.lstrip("/") in topics or name in topics]
    for name in kept:
        writer.add_foreign_topic(bag.topics[name], bag.topics[name].schema)
    for message in bag.messages(kept):
        data = message.data
        if message.topic == "/winch/state":
            state = deserialize_message(data, WinchState)
            for field in TRUE_FIELDS:
                setattr(state, field, math.nan)
            data = serialize_message(state)
        time = logged(message.topic, message.log_time)
        if time is not None:
            writer.write(message.topic, time, data)
    writer.close({})
    return Bag(folder)


@pytest.fixture(scope="module")
def nominal(calm_bag):
    with stored_scenario(Bag(calm_bag)) as scenario:
        return load_scenario(str(scenario), needs_files=False).parameters["winch_controller"]


def test_deleting_every_truth_topic_changes_no_digit(calm_bag, nominal, tmp_path):
    whole = read_record(Bag(calm_bag), nominal)
    bare = read_record(without_truth(Bag(calm_bag), tmp_path / "bare"), nominal)
    assert bare.measurements == whole.measurements
    assert bare.orders == whole.orders
    assert bare.modes == whole.modes
    assert np.array_equal(bare.set_points, whole.set_points)
    assert (bare.first, bare.tick_period, bare.has_adviser) == (whole.first, whole.tick_period, whole.has_adviser)
    assert whole.ticks == 200
    assert whole.measurements[100].winch is not None


def test_when_a_message_was_recorded_changes_no_digit(calm_bag, nominal, tmp_path):
    """In real time it comes late."""
    late = random.Random(1)
    lockstep, bag = Bag(calm_bag), tmp_path / "late"
    realtime = without_truth(lockstep, bag, logged=lambda _, time: time + late.randrange(4 * TICK), pacing="realtime")
    assert read_record(realtime, nominal).measurements == read_record(lockstep, nominal).measurements


def test_a_reading_that_the_bag_lacks_moves_no_other(calm_bag, nominal, tmp_path):
    lost = ("/mru", "/winch/state")
    gap = without_truth(
        Bag(calm_bag),
        tmp_path / "gap",
        logged=lambda topic, time: None if topic in lost and time == 99 * TICK else time,
    )
    found, whole = (read_record(bag, nominal).measurements for bag in (gap, Bag(calm_bag)))
    others = [index for index, (one, other) in enumerate(zip(found, whole, strict=True)) if one != other]
    assert others == [98, 99]
    assert (found[98].mru, found[99].winch) == ((), None)


def test_readings_that_come_together_late_or_never_or_are_refused_are_in_the_tick_of_their_gate():
    readings = [WireReading(number * TICK, (float(number),)) for number in range(1, 9)]
    # two in tick 3; none in 4; 4 is lost on the way; 6 is refused; then 7 and 8 together, 8 refused
    judged, newest = [1, 0, 2, 0, 1, 1, 0, 2], [1, 1, 3, 3, 5, 5, 5, 7]
    ticks = np.arange(1, 9)
    found = delivered(readings, Gate(TICK * ticks, np.array(judged), TICK * np.array(newest)), TICK)
    assert {tick: [int(one.numbers[0]) for one in of_tick] for tick, of_tick in found.items()} == {
        1: [1],
        3: [2, 3],
        5: [5],
        6: [6],
        8: [7],
    }


def test_readings_of_a_sensor_with_a_clock_of_its_own_have_the_stamps_that_the_controller_gave_them():
    clock = 1_800_000_000 * 1_000_000_000 + 7
    readings = [WireReading(clock + number * TICK, (float(number),)) for number in range(1, 6)]
    # none in tick 3, two in 4; the fifth is refused
    judged, newest = [1, 1, 0, 2, 1], [1, 2, 2, 4, 4]
    found = delivered(readings, Gate(TICK * np.arange(1, 6), np.array(judged), TICK * np.array(newest)), TICK)
    assert [(tick, one.stamp // TICK, one.numbers[0]) for tick, of_tick in found.items() for one in of_tick] == [
        (1, 1, 1.0),
        (2, 2, 2.0),
        (4, 3, 3.0),
        (4, 4, 4.0),
        (5, 5, 5.0),
    ]


def test_an_answer_of_the_adviser_that_came_too_late_is_not_taken(calm_bag, nominal, tmp_path):
    late = without_truth(
        Bag(calm_bag),
        tmp_path / "late",
        logged=lambda topic, time: time + 30 * TICK if topic.endswith("beliefs") and time < 70 * TICK else time,
    )
    record = read_record(late, nominal).part(2.5)
    assert record.late == {20, 40}
    assert observed_again(record, nominal).beliefs.asked == -1
    assert observed_again(replace(record, late=frozenset()), nominal).beliefs.asked == 40


def test_the_same_law_leaves_out_the_ticks_that_the_controller_left_out(calm_bag, nominal):
    whole = read_record(Bag(calm_bag), nominal)
    controller, given, orders = WinchController(nominal, tick_period=whole.tick_period), [], []
    for tick, one in enumerate(whole.measurements, start=1):
        if tick in (81, 82):
            controller.leave_out(tick)
            given.append(Measurements())
            orders.append(None)
        else:
            given.append(replace(one, mru=whole.measurements[tick - 2].mru + one.mru) if tick == 83 else one)
            orders.append(controller.step(tick, given[-1]).order)
    record = replace(whole, measurements=tuple(given), orders=tuple(orders), has_adviser=False)
    assert observed_again(record, nominal).is_same


def test_a_record_in_which_an_operator_acted_is_refused_with_the_time(calm_bag, nominal, monkeypatch):
    """Read of the diagnostics of the controller alone; before that time it is a record as any other."""
    said = ["t = 1.00 s: mode stopped; t = 1.05 s: factor 0.8, speed +0.2 m/s", "t = 0.05 s: fault of mru: gap", "ok"]
    names = ["winch_controller: operator", "wave_vessel: operator", "winch_controller: mode"]
    columns = {TIME: np.array([2.0]), LOG_TIME: np.array([2 * 10**9])}
    for number, (name, words) in enumerate(zip(names, said, strict=True)):
        columns |= {
            f"status[{number}].level": np.array([0]),
            f"status[{number}].name": np.array([name], dtype=object),
            f"status[{number}].message": np.array([words], dtype=object),
        }
    assert first_request(columns) == 1.0
    record = replace(read_record(Bag(calm_bag), nominal), operated=80.0)
    monkeypatch.setattr(fitness, "SHORTEST", -math.inf)
    with pytest.raises(CommandError, match=r"an operator acted at 80\.0 s.*: give --end 80$"):
        fitness.check_record(record, 0.0, "bag")
    assert math.isinf(record.part(70.0).operated)


@pytest.mark.parametrize(
    ("loss", "words"),
    [
        (Loss("encoder", 60.0, 70.0, "frozen"), "what the drum did is not known there; give --end 60"),
        (Loss("depth", 60.0, 70.0, "stale"), "depth was lost from 60.0 s to 70.0 s (stale): the unit's motion is not"),
        (Loss("mru", 2.0, 9.0, "stale"), ""),  # the readings are there: the controller was held up
        (Loss("load_cell", 60.0, 70.0, "frozen"), ""),
    ],
)
def test_a_record_in_which_the_controller_lost_a_sensor_is_refused_with_the_reason(
    calm_bag, nominal, monkeypatch, loss, words
):
    monkeypatch.setattr(fitness, "READ_SHARE", 0.0)
    short = read_record(Bag(calm_bag), nominal)
    many = {name: getattr(short, name) * 12 for name in ("measurements", "orders", "modes")}
    with pytest.raises(CommandError, match=re.escape(words)) if words else contextlib.nullcontext():
        fitness.check_record(replace(short, **many, losses=(loss,)), 0.0, "bag")


@pytest.mark.long
def test_the_same_law_gives_a_record_in_real_time_again(nominal, tmp_path):
    bag = run_scenario(tmp_path / "run", duration=30.0, options=("--pacing", "realtime", "--composed"))
    record = read_record(Bag(bag), nominal)
    assert record.ticks == 600
    assert observed_again(record, nominal).is_same


@pytest.mark.parametrize(
    ("left_out", "words"),
    [
        ("unit/pressure", "holds no unit/pressure: the unit's motion is not measured, so it cannot be predicted"),
        ("mru", "holds no mru: the boom tip's motion is not known"),
        ("controller/state", "holds no controller/state: what the controller was given in each tick is not known"),
        ("winch/command", "holds no winch/command: what the winch was ordered is not known"),
    ],
)
def test_a_bag_without_a_sensor_is_refused_in_one_line(calm_bag, tmp_path, left_out, words):
    kept = tuple(topic for topic in SELECTION if topic != left_out)
    without_truth(Bag(calm_bag), tmp_path / "bag", topics=kept)
    status, said, complaint = heave(["whatif", str(tmp_path / "bag")])
    assert status == 1
    assert words in complaint
    assert judge(status, said, complaint) == ""


@pytest.mark.parametrize(
    ("options", "status", "words"),
    [
        ((), 1, "0 s are left after its transient"),
        (("--law", "best"), 2, "best: no such law; known:"),
        (("--set", "cable_sim.length=500"), 2, "cable_sim.length cannot be asked"),
        (("--set", "system.sea.peak_period=9"), 2, "cannot be asked"),
        (("--set", "all.duration=20"), 2, "all.duration cannot be asked"),
        (("--end", "-1"), 2, "--end -1: must be 0 or more"),
        (("--transient", "nan"), 2, "--transient nan: must be 0 or more"),
    ],
)
def test_what_cannot_be_answered_is_refused_in_one_line(calm_bag, options, status, words):
    found, said, complaint = heave(["whatif", str(calm_bag), *options])
    assert (found, words in complaint) == (status, True), complaint
    assert judge(found, said, complaint) == ""


def test_a_bag_that_is_cut_is_said_to_be(calm_bag, tmp_path):
    bag = shutil.copytree(calm_bag, tmp_path / "bag")
    (file,) = bag.glob("*.mcap")
    os.truncate(file, file.stat().st_size // 2)
    _, _, complaint = heave(["whatif", str(bag), "--transient", "0"])
    assert re.search(r"warning: \S+\.mcap: .* at byte \d+: everything from [0-9.]+ s on .* lost", complaint)
    assert "s are left after its transient of 0 s" in complaint


@pytest.mark.long
def test_an_answer_is_near_to_what_then_was():
    # a nominal world: the trial's median error was 0.45 points, 2 points are wanted of 95 %
    draw = replace(make_draw(0, 1), recorded="off", asked=("mpc",), settings=(), words="as believed")
    (pair,), _ = run_draw(draw, 0)
    assert not pair.tells, "a winch that stood still shows nothing of itself: here it is as believed"
    assert abs(pair.error) < 0.02


@pytest.mark.long
def test_a_law_at_the_limits_of_a_winch_that_nobody_knew_of_is_refused_not_answered_wrongly(monkeypatch):
    """Of 0.55 m/s, stated as 2 m/s: the efficiency of `industrial` was 36 points off, and outside its band."""
    monkeypatch.setattr(campaign, "DURATION", 180.0)
    settings = ("virtual_winch.speed_limit=0.55", "virtual_winch.hauling_speed_share=1.0")
    draw = Draw(0, "b3_deep_900", 1, "mpc", ("industrial",), settings, "0.55 m/s")
    pairs, line = run_draw(draw, 0)
    assert pairs == []
    assert "industrial gives up [refused]" in line


@pytest.mark.long
def test_loops_that_are_closed_in_other_processes_answer_alike(monkeypatch):
    monkeypatch.setattr(campaign, "DURATION", 70.0)
    scenario = scenario_of(make_draw(0, 1), "off")
    _, record = Recording(scenario).record()
    nominal = scenario.parameters["winch_controller"]
    known = learn(record, nominal, start=40.0)
    asked = [Asked(law, replace(nominal, law=law)) for law in ("lqg", "off")]
    here = answers(known, asked, [known])
    with workers(2) as run:
        there = answers(known, asked, [known], run=run)
    for one, other in zip(here, there, strict=True):
        assert one.figures.values == other.figures.values
        assert one.figures.bands == other.figures.bands
        assert np.array_equal(one.done.payout, other.done.payout)
    # a draw that is the record's own plant and winch spreads nothing
    assert here[0].figures.bands["winch_speed_max_mps"] == (here[0].figures.values["winch_speed_max_mps"],) * 2
