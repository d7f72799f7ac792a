"""What each verb asks of whom, and what becomes of the answer."""

from heave_bringup.operate.requests import (
    NODE_OF_DEVICE,
    Answer,
    refusal,
    request_factor,
    request_fault,
    request_mode,
    request_snapshot,
)
from heave_bringup.parser import make_parser
from heave_msgs.srv import SaveSnapshot, SetMode
from heave_node.interface.topics import ALL_TOPICS
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters


def test_a_mode_is_answered_by_what_was_taken():
    request = request_mode("compensating")
    assert request.judge(SetMode.Response(success=True, message="compensating")) == Answer("mode compensating")
    told = request.judge(SetMode.Response(success=True, message="standby, on the way to compensating"))
    assert told == Answer("compensating: standby, on the way to compensating")
    assert request.judge(SetMode.Response(message="a sensor is lost")) == refusal("a sensor is lost")


def test_consent_to_an_mru_without_a_witness_is_asked_for_on_purpose():
    assert not request_mode("compensating").message.accept_unproved
    assert request_mode("compensating", unproved=True).message.accept_unproved
    assert make_parser().parse_args(["operate", "mode", "compensating", "--unproved"]).unproved
    assert not make_parser().parse_args(["operate", "mode", "compensating"]).unproved


def test_a_fault_is_asked_of_the_node_that_publishes_the_device():
    publishers = {topic.name: topic.publisher for topic in ALL_TOPICS}
    assert NODE_OF_DEVICE["mru"] == publishers["mru"]
    assert NODE_OF_DEVICE["depth"] == publishers["unit/pressure"]
    assert NODE_OF_DEVICE["encoder"] == NODE_OF_DEVICE["winch"] == publishers["winch/state"]
    assert NODE_OF_DEVICE["crane"] == publishers["crane/pose"]
    assert request_fault("depth", "nan").service == "cable_sim/inject_fault"


def test_every_device_is_offered_on_the_command_line():
    for device in NODE_OF_DEVICE:
        assert make_parser().parse_args(["operate", "fault", "inject", device, "freeze"]).device == device


def test_a_factor_is_a_parameter_of_the_controller_and_its_refusal_is_told():
    request = request_factor(0.5)
    assert request.service == "winch_controller/set_parameters"
    (parameter,) = request.message.parameters
    assert (parameter.name, parameter.value.double_value) == ("factor", 0.5)
    no = SetParameters.Response(results=[SetParametersResult(successful=False, reason="out of range")])
    assert request.judge(no) == refusal("out of range")


def test_a_snapshot_is_told_with_its_folder_and_asked_for_by_an_absolute_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    request = request_snapshot(10.0, tmp_path.relative_to(tmp_path) / "here")
    assert request.message.directory == str(tmp_path / "here")
    said = request.judge(SaveSnapshot.Response(success=True, message="/runs/here", messages=7))
    assert said == Answer("snapshot: 7 messages in /runs/here")
