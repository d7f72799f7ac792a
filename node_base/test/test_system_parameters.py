"""What stands under `system.`: who takes it, what wins, what is refused."""

from dataclasses import dataclass

import pytest
from heave_node.parameters import Given, ParameterError, group, parameter
from heave_node.run_parameters import build_node_parameters
from heave_node.system_parameters import SHARED, SYSTEM, owned_names, system_names, take_system

CONTROLLER = ("law", "length", "sea.peak_period", "sea.swell.shape", "cable.diameter", "winch.time_constant")
VESSEL = ("ramp", "peak_period", "swell.shape", "vessel.gain", "mru.noise")


def given(**values):
    names = {name.replace("__", "."): value for name, value in values.items()}
    return {name: Given(value, name, "f.yaml: /**") for name, value in names.items()}


def test_each_node_takes_a_shared_value_under_its_own_name():
    values = given(system__sea__peak_period=8.0, system__sea__swell__shape=3.0, system__cable__diameter=0.05)
    vessel, controller = take_system("wave_vessel", VESSEL, values), take_system("winch_controller", CONTROLLER, values)
    assert {name: value.value for name, value in vessel.items()} == {"peak_period": 8.0, "swell.shape": 3.0}
    assert {name: value.value for name, value in controller.items()} == {
        "sea.peak_period": 8.0,
        "sea.swell.shape": 3.0,
        "cable.diameter": 0.05,
    }
    assert take_system("recorder", ("directory",), values) == {}


def test_a_value_of_its_own_wins_over_the_shared_one():
    values = {**given(system__sea__peak_period=8.0), **given(peak_period=9.0, ramp=1.0)}
    assert {name: value.value for name, value in take_system("wave_vessel", VESSEL, values).items()} == {
        "peak_period": 9.0,
        "ramp": 1.0,
    }


@pytest.mark.parametrize(
    ("node", "own", "name", "words"),
    [
        ("wave_vessel", VESSEL, "system.sea.peak_perid", "did you mean system.sea.peak_period?"),
        ("winch_controller", CONTROLLER, "system.sea.peak_perid", "did you mean system.sea.peak_period?"),
        ("recorder", ("directory",), "system.cabel.diameter", "did you mean system.cable.?"),
        ("wave_vessel", VESSEL, "system.vessel.gian", "did you mean system.vessel.gain?"),
    ],
)
def test_a_name_that_nobody_knows_is_refused_by_whoever_reads_it(node, own, name, words):
    with pytest.raises(ParameterError) as refusal:
        take_system(node, own, {name: Given(1.0, name, "f.yaml: /**")})
    assert str(refusal.value).startswith(f"f.yaml: /**: there is no parameter {name}; ")
    assert words in str(refusal.value)


def test_a_name_that_only_its_owner_knows_is_no_business_of_the_others():
    values = given(system__vessel__pitch_gain=1.0, system__vessel__gian=1.0)
    assert take_system("winch_controller", CONTROLLER, values) == {}


def test_a_node_without_any_shared_parameter_owns_none_whatever_it_is_called():
    assert take_system("wave_vessel", ("bag",), given(system__vessel__pitch_gain=1.0)) == {}


def test_a_wrong_shared_value_is_told_by_the_name_that_was_given_and_by_the_node_that_cannot_take_it():
    @dataclass(frozen=True)
    class Sea:
        peak_period: float = parameter(8.0, "s", 1.0, 40.0, "Peak period.")

    @dataclass(frozen=True)
    class Controller:
        sea: Sea = group(Sea)

    values = given(system__sea__peak_period=0.5)
    with pytest.raises(ParameterError) as refusal:
        build_node_parameters("winch_controller", Controller, values, where="f.yaml: winch_controller")
    assert str(refusal.value) == (
        "f.yaml: /**: system.sea.peak_period = 0.5 is not allowed for winch_controller: it must be a number from 1 to "
        "40 [s]"
    )


def test_no_two_words_cover_the_same_name():
    words = [shared.word for shared in SHARED]
    assert len(set(words)) == len(words)
    for shared in SHARED:
        assert [other.word for other in SHARED if other.covers(shared.word)] == [shared.word]


def test_owned_names_are_those_whose_word_the_node_comes_first_in():
    assert set(owned_names("wave_vessel", VESSEL)) == {
        f"{SYSTEM}{name}" for name in ("sea.peak_period", "sea.swell.shape", "vessel.gain", "sensors.mru.noise")
    }
    assert owned_names("winch_controller", CONTROLLER) == {}
    assert system_names("winch_controller", CONTROLLER)["system.length"] == "length"
