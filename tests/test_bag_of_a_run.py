"""What a run leaves behind: a bag that every tool reads, complete, and the same byte for byte when the run is
repeated."""

import json
import re
from collections import Counter

import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from tests.loop_runs import CALM_DURATION, heave, recorded_messages, run_scenario

TICKS = round(CALM_DURATION / 0.05)
EVERY_TICK = (
    "/clock",
    "/boom_tip",
    "/mru",
    "/wave_elevation",
    "/vessel/odometry",
    "/cable/state",
    "/unit/odometry",
    "/unit_uncompensated",
    "/winch/command",
    "/winch/state",
    "/controller/state",
)


def test_every_topic_has_the_messages_of_every_tick(calm_bag):
    counts = Counter(topic for topic, _, _ in recorded_messages(calm_bag))
    assert {topic: counts[topic] for topic in EVERY_TICK} == dict.fromkeys(EVERY_TICK, TICKS)
    assert counts["/sea_state"] == counts["/wave_components"] == 1
    assert counts["/unit/pressure"] > 0.9 * CALM_DURATION * 10.0
    assert not [topic for topic in counts if "/_" in topic]


def test_log_times_are_simulated_times_in_order(calm_bag):
    times = [time for _, time, _ in recorded_messages(calm_bag)]
    assert times == sorted(times)
    assert times[0] == 50_000_000
    assert times[-1] == TICKS * 50_000_000


def test_metadata_agrees_with_the_file(calm_bag):
    metadata = yaml.safe_load((calm_bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    counts = Counter(topic for topic, _, _ in recorded_messages(calm_bag))
    stated = {t["topic_metadata"]["name"]: t["message_count"] for t in metadata["topics_with_message_count"]}
    assert {topic: count for topic, count in stated.items() if count} == counts
    assert metadata["message_count"] == sum(counts.values())
    assert metadata["storage_identifier"] == "mcap"


def test_rosbags_decodes_every_message(calm_bag):
    with AnyReader([calm_bag]) as reader:
        decoded = Counter()
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)
            decoded[connection.topic] += 1
    assert decoded == Counter(topic for topic, _, _ in recorded_messages(calm_bag))


def test_mcap_ros2_support_decodes_every_message(calm_bag):
    decoded = 0
    for file in sorted(calm_bag.glob("*.mcap")):
        with file.open("rb") as stream:
            for _ in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
                decoded += 1
    assert decoded == len(recorded_messages(calm_bag))


def test_the_bag_says_what_it_is(calm_bag):
    metadata = yaml.safe_load((calm_bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    custom = metadata["custom_data"]
    assert "b2_calm_300" in json.dumps(custom)
    with next(calm_bag.glob("*.mcap")).open("rb") as stream:
        attachments = {attachment.name: attachment.data for attachment in make_reader(stream).iter_attachments()}
    assert any(b"wave_vessel" in data for data in attachments.values())


@pytest.mark.slow
def test_the_same_seed_gives_the_same_bytes_and_another_seed_does_not(calm_bag, tmp_path):
    again = run_scenario(tmp_path / "again", duration=CALM_DURATION)
    assert recorded_messages(again) == recorded_messages(calm_bag)
    other = run_scenario(
        tmp_path / "other", duration=1.0, options=["--composed", "--seed", "2", "--set", "all.transient=0"]
    )
    assert not {m for m in recorded_messages(other) if m[0] == "/boom_tip"} <= set(recorded_messages(calm_bag))


def test_kpi_and_report_work_on_the_bag(calm_bag, tmp_path):
    result = heave("kpi", str(calm_bag), "--json", "-")
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout)["missed_deadlines"] == 0
    page = tmp_path / "report.html"
    result = heave("report", str(calm_bag), "--output", str(page))
    assert result.returncode == 0, result.stderr
    text = page.read_text()
    loaded = re.findall(r'<(?:script|link|img)[^>]*(?:src|href)="http[^>]*', text)
    assert not loaded, "the report opens offline: it loads nothing"
    assert "<html" in text
