"""A bag in the place of all nodes but the controller gives the same run; and markers in a bag show the cable."""

import pytest
from heave_bags.mcap.reader import Bag
from visualization_msgs.msg import Marker

from tests.loop_runs import CALM_DURATION, heave, run_scenario


@pytest.mark.slow
def test_recorded_sea_and_sensors_lead_the_same_controller_to_the_same_run(calm_bag, tmp_path):
    replaced = ("wave_vessel", "cable_sim", "virtual_winch")
    options = [part for node in replaced for part in ("--replace", f"{node}=bag:{calm_bag}")]
    again = run_scenario(tmp_path / "again", duration=CALM_DURATION, options=options)
    assert Bag(again).run["replaced"].split() == [f"{node}=bag" for node in replaced]
    assert list(Bag(again).messages()) == list(Bag(calm_bag).messages())


def test_a_bag_that_is_too_short_is_refused_in_one_line(calm_bag, tmp_path):
    result = heave(
        *("run", "b2_calm_300", "--duration", "100", "--bag", str(tmp_path / "again"), "--no-report"),
        *("--replace", f"wave_vessel=bag:{calm_bag}"),
    )
    assert result.returncode != 0
    assert "the run lasts 100 s" in result.stderr.strip().splitlines()[-1]


def test_markers_show_the_cable_and_the_unit_where_they_are(calm_bag):
    bag = Bag(calm_bag)
    cables = {message.log_time: state for message, state in bag.decoded(["cable/state"])}
    units = {message.log_time: state for message, state in bag.decoded(["unit/odometry"])}
    seen = 0
    for message, array in bag.decoded(["markers"]):
        strips = [marker for marker in array.markers if marker.type == Marker.LINE_STRIP]
        nodes = [(node.x, node.y, node.z) for node in cables[message.log_time].nodes]
        assert any([(point.x, point.y, point.z) for point in strip.points] == nodes for strip in strips)
        unit = units[message.log_time].pose.pose.position
        bodies = [
            m.pose.position for m in array.markers if m.type in (Marker.CUBE, Marker.SPHERE, Marker.MESH_RESOURCE)
        ]
        assert any((body.x, body.y, body.z) == pytest.approx((unit.x, unit.y, unit.z), abs=1e-9) for body in bodies)
        assert {marker.header.frame_id for marker in array.markers} == {"world"}
        seen += 1
    assert seen >= CALM_DURATION
