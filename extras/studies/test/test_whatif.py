"""`heave whatif`: only sensors are read, the same law gives it again, what cannot carry an answer is refused."""

import contextlib
import math
import os
import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from cable_sim_node.winch.parameters import WinchParameters
from heave_bags.mcap.bag_writer import Attachment, BagWriter
from heave_bags.mcap.reader import LOG_TIME, TIME, Bag
from heave_bringup.errors import CommandError
from heave_msgs.msg import WinchState
from heave_studies.kappa import stored_scenario
from heave_studies.study.workers import workers
from heave_studies.whatif import fitness
from heave_studies.whatif.answer import answers, learn
from heave_studies.whatif.record import NOMINAL, SELECTION, first_request, read_record
from heave_studies.whatif.spectra import Tip
from heave_studies.whatif.twin import Asked, Drive, Past, Replay, driven, nominal_line, past_winch, winch_under
from rclpy.serialization import deserialize_message, serialize_message

from tests.campaigns import whatif as campaign
from tests.campaigns.in_process import heave, judge
from tests.campaigns.whatif import Draw, Recording, make_draw, run_draw, scenario_of

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
    return stored_scenario(Bag(calm_bag)).parameters["winch_controller"]


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


def test_the_same_law_gives_a_record_again(calm_bag, nominal):
    """The controller's own bag in lockstep, with its adviser: every order, and so no difference of the twins."""
    record = read_record(Bag(calm_bag), nominal)
    still = np.zeros(record.ticks)
    drive = Drive(nominal_line(nominal), nominal.length, Tip(still, still, 0.0), still, still, record.tick_period)
    past = Past(record, drive, past_winch(record, winch_under(NOMINAL, nominal)), WinchParameters(), driven(drive))
    loop = Replay(past, Asked(nominal))
    assert loop.run().modes == record.modes
    assert not loop.is_other


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
    with pytest.raises(CommandError, match=r"from 80\.0 s on an operator acted.*: give --end 80$"):
        fitness.check_record(record, 0.0, "bag")
    assert math.isinf(record.part(70.0).operated)


@pytest.mark.parametrize(
    ("sensor", "words"),
    [
        ("mru", "from 3.0 s on mru was not read until 5.0 s: give --end 3"),
        ("depth", "from 2.9 s on depth was not read until 4.9 s"),
        ("encoder", "encoder was not read until 5.0 s"),
        ("load_cell", ""),
    ],
)
def test_a_record_in_which_a_sensor_did_not_read_is_refused_with_the_time(
    calm_bag, nominal, monkeypatch, sensor, words
):
    monkeypatch.setattr(fitness, "SHORTEST", -math.inf)
    whole = read_record(Bag(calm_bag), nominal)
    without = {"mru": {"mru": ()}, "encoder": {"winch": None}}
    given = [
        replace(one, **without.get(sensor, {"scalar": {**one.scalar, sensor: ()}})) if 3.0 < time < 5.0 else one
        for time, one in zip(whole.time, whole.measurements, strict=True)
    ]
    with pytest.raises(CommandError, match=words) if words else contextlib.nullcontext():
        fitness.check_record(replace(whole, measurements=tuple(given)), 0.0, "bag")


@pytest.mark.parametrize(
    ("left_out", "words"),
    [
        ("unit/pressure", "holds no unit/pressure: the unit's motion is not measured, so it cannot be predicted"),
        ("mru", "holds no mru: the boom tip's motion is not known"),
        ("controller/state", "holds no controller/state: about which payout the winch worked is not known"),
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
        (("--end", "-1"), 1, "0 s are left after its transient"),
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
    _, _, complaint = heave(["whatif", str(bag)])
    assert re.search(
        r"warning: not all of the bag could be read: \S+\.mcap: .* at byte \d+: everything from [0-9.]+ s on .* lost",
        complaint,
    )
    assert "s are left after its transient" in complaint


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
    asked = [Asked(replace(nominal, law=law)) for law in ("lqg", "off")]
    here = answers(known, asked, [known])
    with workers(2) as run:
        there = answers(known, asked, [known], run=run)
    for one, other in zip(here, there, strict=True):
        assert one.figures.values == other.figures.values
        assert one.figures.bands == other.figures.bands
        assert np.array_equal(one.done.payout, other.done.payout)
    # a draw that is the record's own plant and winch spreads nothing
    assert here[0].figures.bands["winch_speed_max_mps"] == (here[0].figures.values["winch_speed_max_mps"],) * 2
