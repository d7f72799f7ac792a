"""A design in parts and back: equal to the bit, and whatever is wrong with what came is one clear error."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from heave_node.parameters import flatten
from hypothesis import given
from hypothesis import strategies as st
from winch_controller_node.beliefs.quantities import with_value
from winch_controller_node.design.design import ControllerDesign, design_controller
from winch_controller_node.design.wire import (
    DesignParts,
    WireError,
    design_of,
    parameters_of,
    parameters_text,
    parts_of,
)
from winch_controller_node.laws.parts.loop_state import LoopState, Reference
from winch_controller_node.laws.registry import LAWS
from winch_controller_node.node_parameters import WinchControllerParameters


@cache
def design() -> ControllerDesign:
    return design_controller(WinchControllerParameters(), tick_period=0.05).with_own_gains()


@cache
def parts() -> DesignParts:
    return parts_of(design())


ARRAYS, TEXTS = sorted(parts().arrays), sorted(parts().texts)


def with_array(name, array) -> DesignParts:
    return DesignParts({**parts().arrays, name: array}, parts().texts)


def with_texts(name, *texts) -> DesignParts:
    return DesignParts(parts().arrays, {**parts().texts, name: texts})


def test_a_design_comes_back_equal_to_the_bit():
    again = design_of(parts())
    for name, array in parts_of(again).arrays.items():
        assert array.tobytes() == parts().arrays[name].tobytes(), name
    assert parts_of(again).texts == parts().texts
    assert again.parameters == design().parameters
    assert again.cable == design().cable
    assert again.sigma == design().sigma
    assert [vars(replace(one, row=None)) for one in again.measurements] == [
        vars(replace(one, row=None)) for one in design().measurements
    ]


@pytest.mark.parametrize("law", LAWS)
def test_a_law_by_gains_that_came_with_its_design_is_the_one_that_makes_them_itself(law):
    """To the bit, while no limit acts."""
    sensors = replace(WinchControllerParameters().sensors, use=("mru", "encoder", "depth"))
    parameters = replace(WinchControllerParameters(), law=law, sensors=sensors)
    plain = design_controller(parameters, tick_period=0.05)
    came = design_of(parts_of(plain.with_own_gains()))
    assert tuple(came.own_gains) == LAWS[law].gain_names
    state = LoopState(0.01 * np.arange(1.0, plain.model.order + 1.0), Reference(), plain.cable.static_tension)
    assert came.make_law().command(state) == plain.make_law().command(state)


def test_gains_of_another_law_are_refused():
    arrays = {**parts().arrays, "own_gains": np.zeros((1, design().model.order))}
    with pytest.raises(WireError, match="own_gains are not those of law"):
        design_of(DesignParts(arrays, {**parts().texts, "own_gains": ("unit",)}))


def test_what_comes_back_lies_in_memory_as_what_was_sent_so_that_products_are_the_same_to_the_bit():
    assert all(array.flags.c_contiguous for array in parts().arrays.values())
    again = design_of(with_array("model.A", np.asfortranarray(parts().arrays["model.A"])))
    assert again.model.A.flags.c_contiguous


@given(name=st.sampled_from(ARRAYS), is_missing=st.booleans())
def test_an_array_that_is_missing_or_of_another_shape_is_named(name, is_missing):
    arrays = dict(parts().arrays)
    array = arrays.pop(name)
    if not is_missing:
        arrays[name] = np.append(array, 1.0).reshape(-1, 1, 1)
    with pytest.raises(WireError, match=name.replace(".", r"\.")):
        design_of(DesignParts(arrays, parts().texts))


@given(name=st.sampled_from([name for name in ARRAYS if parts().arrays[name].size]), data=st.data())
def test_a_number_that_is_not_finite_is_refused_wherever_it_stands(name, data):
    array = parts().arrays[name].copy()
    place = data.draw(st.integers(0, array.size - 1))
    array.reshape(-1)[place] = np.nan
    if name == "cable.unit_weight":
        return  # may be infinite
    with pytest.raises(WireError, match=name.replace(".", r"\.")):
        design_of(with_array(name, array))


@pytest.mark.parametrize("name", TEXTS)
def test_texts_that_are_missing_or_too_few_are_refused(name):
    texts = dict(parts().texts)
    given_texts = texts.pop(name)
    with pytest.raises(WireError, match="is missing"):
        design_of(DesignParts(parts().arrays, texts))
    with pytest.raises(WireError):
        design_of(DesignParts(parts().arrays, {**texts, name: given_texts[:-1]}))


@pytest.mark.parametrize(
    "wrong",
    [
        DesignParts({**parts().arrays, "more": np.zeros(3)}, parts().texts),
        DesignParts(parts().arrays, {**parts().texts, "more": ("word",)}),
        with_texts("model.state_names", *["same"] * design().model.order),
        with_texts("measurements.name", *["same"] * len(design().measurements)),
        with_array("measurements.scale_state", np.full(len(design().measurements), 0.5)),
        with_array("measurements.scale_state", np.full(len(design().measurements), float(design().model.order))),
        with_array("measurements.is_gated", np.full(len(design().measurements), 2.0)),
        with_array("cable.a", np.array(-1.0)),
    ],
    ids=["an array more", "a text more", "names", "measurements", "half a state", "no such state", "gate", "cable"],
)
def test_what_no_design_can_have_is_refused(wrong):
    with pytest.raises(WireError):
        design_of(wrong)


@given(length=st.floats(0.01, 20_000.0), delay=st.floats(0.0, 5.0))
def test_parameters_keep_every_bit_in_their_text(length, delay):
    parameters = with_value(replace(WinchControllerParameters(), length=length), "winch.command_delay", delay)
    assert flatten(parameters_of(parameters_text(parameters))) == flatten(parameters)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("no", "no JSON"),
        ("[1]", "no JSON object"),
        ("{}", "is missing"),
        (json.dumps({**flatten(WinchControllerParameters()), "length": -1.0}), "length = -1.0 is not allowed"),
        (json.dumps({**flatten(WinchControllerParameters()), "length": float("nan")}), "length = nan is not allowed"),
        (json.dumps({**flatten(WinchControllerParameters()), "colour": 1}), "no parameter colour"),
    ],
)
def test_parameters_that_no_controller_may_have_are_refused(text, words):
    with pytest.raises(WireError, match=words):
        parameters_of(text)
