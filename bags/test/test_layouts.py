"""Every topic and field that a layout shows exists, so that nobody opens an empty plot; and markers show the cable."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml
from heave_node.cdr.definitions import schema_text
from heave_node.cdr.layout import PRIMITIVES, parse_schema
from heave_node.interface.topics import ALL_TOPICS

CONFIG = Path(__file__).parent.parent / "config"
TYPE_OF = {f"/{topic.name}": topic.type for topic in ALL_TOPICS}


def assert_exists(topic: str, fields: list[str]) -> None:
    """Follow a path of field names through the definitions of a topic's type."""
    assert topic in TYPE_OF, f"no topic {topic}"
    types = parse_schema(TYPE_OF[topic], schema_text(TYPE_OF[topic]))
    kind = next(iter(types))
    for name in fields:
        member = next((m for m in types[kind] if m.name == re.sub(r"\[\d+\]$", "", name)), None)
        assert member is not None, f"{topic}: {kind} has no field {name}"
        assert name.endswith("]") == (member.count is not None)
        kind = member.type
    assert not fields or kind in PRIMITIVES


def split_path(path: str, separator: str) -> tuple[str, list[str]]:
    """Split "/winch/state.payout" (or with /) into topic and fields: the longest topic that fits."""
    topic = max((t for t in TYPE_OF if path.startswith(t + separator)), key=len, default=path)
    rest = path[len(topic) + 1 :]
    return topic, [part for part in rest.split(separator) if part and not part.startswith("@")]


def foxglove_paths() -> list[str]:
    panels = json.loads((CONFIG / "heave.foxglove.json").read_text())["configById"]
    return [entry["value"] for panel in panels.values() for entry in panel.get("paths", [])]


def plotjuggler_paths() -> list[str]:
    root = ElementTree.parse(CONFIG / "heave.plotjuggler.xml").getroot()
    return [curve.attrib["name"] for curve in root.iter("curve")]


@pytest.mark.parametrize("path", foxglove_paths())
def test_what_foxglove_plots_exists(path):
    assert_exists(*split_path(path, "."))


@pytest.mark.parametrize("path", plotjuggler_paths())
def test_what_plotjuggler_plots_exists(path):
    assert_exists(*split_path(path, "/"))


def test_foxglove_shows_each_panel_once_and_the_markers():
    content = json.loads((CONFIG / "heave.foxglove.json").read_text())

    def leaves(node):
        return [node] if isinstance(node, str) else leaves(node["first"]) + leaves(node["second"])

    assert sorted(leaves(content["layout"])) == sorted(content["configById"])
    assert content["configById"]["3D!loop"]["topics"]["/markers"]["visible"]


def test_rviz_shows_markers_and_bodies_in_the_world_frame():
    content = yaml.safe_load((CONFIG / "heave.rviz").read_text())["Visualization Manager"]
    shown = {d["Topic"]["Value"]: d["Class"].split("/")[1] for d in content["Displays"] if "Topic" in d}
    types = {"MarkerArray": "visualization_msgs/msg/MarkerArray", "Odometry": "nav_msgs/msg/Odometry"}
    assert {topic: types[kind] for topic, kind in shown.items()} == {topic: TYPE_OF[topic] for topic in shown}
    assert "/markers" in shown
    assert content["Global Options"]["Fixed Frame"] == "world"
