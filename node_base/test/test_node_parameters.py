"""Parameters on a ROS node: taken from a file, refused, and described."""

import sys
from dataclasses import dataclass

import pytest
from heave_node.parameters import ParameterError, parameter
from heave_node.scenario import write_sections

rclpy = pytest.importorskip("rclpy")

from heave_node.ros.node_parameters import read_parameters  # noqa: E402


@dataclass(frozen=True)
class Vessel:
    peak_period: float = parameter(8.0, "s", 1.0, 40.0, "Peak period.")
    times: tuple[float, ...] = parameter((), "s", description="Times.")


@pytest.fixture
def read(tmp_path, monkeypatch):
    """Return a function that starts a node `wave_vessel` with a parameter file and reads its parameters."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    opened = []

    def start(sections, namespace="", options=()):
        path = tmp_path / "own.yaml"
        write_sections(sections, path)
        arguments = ["--ros-args", "--params-file", str(path), *options]
        monkeypatch.setattr(sys, "argv", ["node", *arguments])
        context = rclpy.Context()
        rclpy.init(args=arguments, context=context)
        opened.append(context)
        node = rclpy.create_node(
            "wave_vessel", namespace=namespace, context=context, automatically_declare_parameters_from_overrides=True
        )
        return node, *read_parameters(node, Vessel)

    yield start
    for context in opened:
        rclpy.shutdown(context=context)


SCENARIO = {
    "/**": {"seed": 7, "system.sea.peak_period": 9.0, "system.cable.diameter": 0.05, "wanted.kappa": "<= 2"},
    "/**/cable_sim": {"length": 3.0},
}


@pytest.mark.parametrize("namespace", ["", "/ship/north"])
def test_shared_values_reach_a_node_in_any_namespace_and_stand_under_its_own_names(read, namespace):
    node, run, own = read(SCENARIO, namespace)
    assert (run.seed, own.peak_period) == (7, 9.0)
    assert node.get_parameter("peak_period").value == 9.0
    assert not any(name.startswith(("system.", "wanted.")) for name in node.get_parameters_by_prefix(""))
    descriptor = node.describe_parameter("peak_period")
    assert (descriptor.description, descriptor.floating_point_range[0].to_value) == ("Peak period.", 40.0)


def test_the_command_line_and_the_node_s_own_section_win_over_the_shared_value(read):
    assert read({**SCENARIO, "/**/wave_vessel": {"peak_period": 10.0}})[2].peak_period == 10.0
    assert read(SCENARIO, options=["-p", "peak_period:=11.0"])[2].peak_period == 11.0


@pytest.mark.parametrize(
    ("sections", "namespace", "words"),
    [
        (
            {"/**": {"system.sea.peak_period": 0.5}},
            "",
            "own.yaml: /**: system.sea.peak_period = 0.5 is not allowed for",
        ),
        (
            {"/**": {"system.sea.peak_perid": 9.0}},
            "",
            "own.yaml: /**: there is no parameter system.sea.peak_perid; did",
        ),
        ({"/**": {"wanted.kappa": "2"}}, "", "own.yaml: /**: wanted.kappa = '2' is not allowed"),
        ({"/wave_vessel": {"peak_period": "x"}}, "", "own.yaml: /wave_vessel: peak_period = 'x' is not allowed"),
        (
            {"/cable_sim": {"length": 1.0}},
            "",
            "own.yaml: has no parameters for node /wave_vessel; its sections are",
        ),
        ({"/wave_vessel": {"peak_period": 9.0}}, "/ship", "own.yaml: /wave_vessel: does not apply to node /ship/"),
        (
            {"/**": {"seed": 1}, "/wave_vessel": {"peak_period": 9.0}},
            "/ship",
            "own.yaml: /wave_vessel: does not apply to node /ship/wave_vessel; write /**/wave_vessel",
        ),
    ],
)
def test_what_is_wrong_is_told_with_file_and_section(read, sections, namespace, words):
    with pytest.raises(ParameterError) as refusal:
        read(sections, namespace)
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_value_of_the_command_line_is_told_as_such(read):
    with pytest.raises(ParameterError, match=r"wave_vessel: command line: peak_period = 0\.5 is not allowed"):
        read(SCENARIO, options=["-p", "peak_period:=0.5"])
