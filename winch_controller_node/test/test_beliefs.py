"""What the beliefs may replace, and the parameters under them."""

import dataclasses
import math
from types import MappingProxyType

import pytest
from heave_core.watch import Drum
from hypothesis import given
from hypothesis import strategies as st
from winch_controller_node.beliefs.beliefs import (
    AS_READ,
    USED,
    Belief,
    Beliefs,
    Correction,
    corrections,
    parameters_under,
    without_sea,
)
from winch_controller_node.beliefs.drum import QUANTITY_OF, drum_of
from winch_controller_node.beliefs.quantities import QUANTITIES, RESTATED, restated, with_value
from winch_controller_node.node_parameters import WinchControllerParameters

NOMINAL = WinchControllerParameters()
LIMITS = ("winch.speed_out", "winch.speed_in", "winch.acceleration_out", "winch.acceleration_in", "winch.power_limit")


def held(**values):
    """Return beliefs of some values, by quantity with its dots doubled to underscores."""
    named = {name.replace("__", "."): value for name, value in values.items()}
    return Beliefs(0, values=MappingProxyType({name: Belief(name, value) for name, value in named.items()}))


def at(holder, path):
    for name in path.split("."):
        holder = getattr(holder, name)
    return holder


@pytest.mark.parametrize("name", QUANTITIES)
def test_each_quantity_has_an_owner_and_its_nominal_value_is_that_of_its_parameter(name):
    quantity = QUANTITIES[name]
    assert quantity.owner in ("winch", "encoder", "depth", "mru", "cable", "sea")
    nominal = quantity.nominal_in(NOMINAL)
    assert nominal == (at(NOMINAL, quantity.path) if quantity.path else quantity.nominal)
    assert Beliefs(0).value(name, NOMINAL) == nominal
    assert held(**{name.replace(".", "__"): 0.123}).value(name, NOMINAL) == 0.123


@pytest.mark.parametrize("name", [name for name, one in QUANTITIES.items() if one.path and name not in LIMITS])
def test_the_parameters_under_a_belief_differ_from_the_nominal_ones_in_what_is_believed_alone(name):
    path = QUANTITIES[name].path
    value = 0.9 * at(NOMINAL, path) + 0.01
    under = parameters_under(held(**{name.replace(".", "__"): value}), NOMINAL)
    assert at(under, path) == pytest.approx(value)
    assert with_value(under, path, at(NOMINAL, path)) == NOMINAL


@pytest.mark.parametrize("name", [name for name, one in QUANTITIES.items() if not one.path])
def test_what_no_parameter_holds_changes_no_parameter(name):
    assert parameters_under(held(**{name.replace(".", "__"): 0.3}), NOMINAL) == NOMINAL


@pytest.mark.parametrize(
    ("assumed", "speed", "acceleration"),
    [
        ({"winch__speed_out": 1.4}, USED * 1.4, None),
        ({"winch__speed_out": 1.4, "winch__speed_in": 1.1}, USED * 1.1, None),
        ({"winch__acceleration_in": 0.8}, None, USED * 0.8),
        ({"winch__acceleration_out": 0.7, "winch__acceleration_in": 0.9, "winch__speed_in": 1.0}, USED, USED * 0.7),
    ],
)
def test_of_a_limit_that_was_identified_a_little_less_is_used_and_the_weaker_direction_counts(
    assumed, speed, acceleration
):
    winch = parameters_under(held(**assumed), NOMINAL).winch
    assert winch.speed_limit == pytest.approx(speed or NOMINAL.winch.speed_limit)
    assert winch.acceleration_limit == pytest.approx(acceleration or NOMINAL.winch.acceleration_limit)


def test_of_a_power_that_was_identified_a_little_less_is_used():
    assert parameters_under(held(winch__power_limit=5e4), NOMINAL).winch.power_limit == pytest.approx(USED * 5e4)


def test_beliefs_without_the_sea_are_all_the_others():
    beliefs = held(sea__peak_period=12.0, sea__swell__peak_period=18.0, mru__scale=1.1, winch__speed_gain=0.8)
    beliefs = dataclasses.replace(beliefs, excluded="depth", authority=0.3, number=4)
    plain = without_sea(beliefs)
    assert set(plain.values) == {"mru.scale", "winch.speed_gain"}
    assert (plain.excluded, plain.authority, plain.number) == ("depth", 0.3, 4)
    # a design is one for a sea
    assert (plain.design, plain.adopted) == (None, None)


@given(st.dictionaries(st.sampled_from(RESTATED), st.floats(0.5, 20.0), max_size=5))
def test_what_an_operator_has_stated_anew_is_told_by_path_and_makes_his_parameters_of_the_first(changes):
    now = NOMINAL
    for path, value in changes.items():
        now = with_value(now, path, value)
    found = restated(NOMINAL, now)
    assert {path for path, _ in found} == {path for path, value in changes.items() if value != at(NOMINAL, path)}
    again = NOMINAL
    for path, value in found:
        again = with_value(again, path, value)
    assert again == now


def test_sensors_are_corrected_by_what_is_believed_of_them():
    beliefs = held(mru__scale=1.2, mru__offset=0.3, mru__delay=0.1, depth__scale=-1.0, encoder__scale=2.0)
    found = corrections(beliefs, NOMINAL)
    assert found == {"mru": Correction(1.2, 0.3, 0.1), "depth": Correction(-1.0)}
    assert corrections(Beliefs(0), NOMINAL) == {"mru": AS_READ, "depth": AS_READ}


def test_each_field_of_a_drum_but_its_reach_can_be_believed():
    assert set(QUANTITY_OF) == set(Drum._fields) - {"reach"}
    assert set(QUANTITY_OF.values()) <= set(QUANTITIES)
    nominal = drum_of(NOMINAL.winch)
    assert (nominal.lag, nominal.delay, nominal.gain) == (0.15, 0.2, 1.0)
    assert (nominal.speed_out, nominal.speed_in, nominal.acceleration_in) == (2.0, 2.0, 1.5)
    for field, quantity in QUANTITY_OF.items():
        assert drum_of(NOMINAL.winch, {quantity: 0.07}) == nominal._replace(**{field: 0.07})
    assert math.isfinite(sum(nominal))
