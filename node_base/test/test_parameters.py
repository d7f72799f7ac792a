"""Parameter sets: what is accepted, what is refused and in which words."""

import math
from dataclasses import dataclass

import pytest
from heave_node.parameters import (
    Given,
    ParameterError,
    build_parameters,
    describe,
    flatten,
    group,
    parameter,
    unknown_parameter,
)
from hypothesis import given
from hypothesis import strategies as st


@dataclass(frozen=True)
class Inner:
    mass: float = parameter(1.0, "kg", 0.0, None, "Mass.")
    area: tuple[float, ...] = parameter((1.0, 2.0, 3.0), "m^2", 0.0, None, "Areas.", length=3)
    stiffness: float = 2.0  # a constant [N/m]


@dataclass(frozen=True)
class Outer:
    count: int = parameter(3, "", 1, 10, "Count.")
    kind: str = parameter("a", description="Kind.", choices=("a", "b"))
    on: bool = parameter(True, description="Switch.")
    unit: Inner = group(Inner, mass=5.0)

    def __post_init__(self) -> None:
        if self.count > 5 and not self.on:
            raise ValueError("count above 5 needs on: true")


def build(**values):
    return build_parameters(
        Outer, {name.replace("__", "."): value for name, value in values.items()}, where="f.yaml: n"
    )


def test_defaults_hold_where_nothing_is_given_and_a_group_may_change_them():
    assert build() == Outer()
    assert build().unit.mass == 5.0


def test_a_field_that_is_no_parameter_is_a_constant_that_no_file_can_set():
    assert [one.name for one in describe(Inner)] == ["mass", "area"]
    assert set(flatten(Inner(stiffness=3.0))) == {"mass", "area"}
    with pytest.raises(ParameterError, match=r"there is no parameter unit\.stiffness"):
        build(unit__stiffness=3.0)


def test_dotted_names_reach_into_groups():
    assert build(unit__mass=2.5).unit == Inner(mass=2.5)


def test_a_whole_number_is_taken_for_a_float_and_nothing_else_is_converted():
    assert build(unit__mass=2).unit.mass == 2.0
    for wrong in ({"count": 2.0}, {"count": True}, {"on": 1}, {"kind": 1}, {"unit__mass": "2"}, {"unit__mass": None}):
        with pytest.raises(ParameterError):
            build(**wrong)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"count": 11}, "f.yaml: n: count = 11 is not allowed: it must be a whole number from 1 to 10"),
        ({"kind": "c"}, "one of a, b"),
        ({"unit__mass": -1.0}, "unit.mass = -1.0 is not allowed: it must be a number of at least 0 [kg]"),
        ({"unit__mass": math.nan}, "unit.mass = nan"),
        ({"unit__area": [1.0, 2.0]}, "a list of 3 values"),
        ({"unit__mas": 1.0}, "there is no parameter unit.mas; did you mean unit.mass?"),
        ({"zzz": 1.0}, "known: count, kind, on, unit.area, unit.mass"),
        ({"count": 6, "on": False}, "count above 5 needs on: true"),
    ],
)
def test_a_refusal_says_where_what_and_what_is_allowed(values, words):
    with pytest.raises(ParameterError) as refusal:
        build(**values)
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


@given(st.integers(1, 5), st.sampled_from("ab"), st.floats(0, 1e6), st.lists(st.floats(0, 10), min_size=3, max_size=3))
def test_flatten_is_the_inverse_of_build(count, kind, mass, area):
    values = {"count": count, "kind": kind, "unit.mass": mass, "unit.area": area}
    assert flatten(build_parameters(Outer, values, where=""))["unit.area"] == tuple(area)
    assert build_parameters(Outer, flatten(build_parameters(Outer, values, where="")), where="") == build_parameters(
        Outer, values, where=""
    )


def test_a_set_that_contradicts_itself_is_told_with_where_it_stands_whatever_it_raises():
    @dataclass(frozen=True)
    class Winch:
        lower: float = parameter(0.0, "m", description="Lower end.")

        def __post_init__(self) -> None:
            if self.lower > 1.0:
                raise ParameterError("lower must be below upper")

    with pytest.raises(ParameterError, match=r"^f\.yaml: winch: lower must be below upper$"):
        build_parameters(Winch, {"lower": 2.0}, where="f.yaml: winch")


def test_of_many_names_the_message_lists_the_groups_only():
    names = [f"group{number % 3}.name{number}" for number in range(30)]
    error = unknown_parameter(Given(1, "zzz", "f.yaml: n"), names)
    assert str(error) == "f.yaml: n: there is no parameter zzz; known: group0, group1, group2"
    error = unknown_parameter(Given(1, "g.qwertyuiop", "f.yaml: n"), [*names, "g.unit", "g.payout"])
    assert str(error) == "f.yaml: n: there is no parameter g.qwertyuiop; known: g.payout, g.unit"


def test_every_parameter_is_described():
    infos = {info.name: info for info in describe(Outer)}
    assert list(infos) == ["count", "kind", "on", "unit.mass", "unit.area"]
    assert infos["unit.mass"].default == 5.0
    assert all(info.description for info in infos.values())


def test_a_choice_that_was_written_without_quotes_is_meant_whatever_it_is_read_as():
    @dataclass(frozen=True)
    class Law:
        law: str = parameter("mpc", description="Law.", choices=("off", "mpc"))
        faults: tuple[str, ...] = parameter((), description="Faults.", choices=("freeze", "nan"))

    assert build_parameters(Law, {"law": False}, where="x").law == "off"
    assert build_parameters(Law, {"faults": [math.nan, "freeze"]}, where="x").faults == ("nan", "freeze")
    for wrong in ({"law": True}, {"law": math.nan}, {"faults": [1.0]}, {"faults": [False]}):
        with pytest.raises(ParameterError):
            build_parameters(Law, wrong, where="x")


def test_a_text_that_was_read_as_a_number_is_refused_with_what_to_write():
    @dataclass(frozen=True)
    class Recorder:
        directory: str = parameter("bag", description="Folder.")

    with pytest.raises(
        ParameterError, match=r'directory = 2026 is not allowed: it must be a string, in quotes: "2026"'
    ):
        build_parameters(Recorder, {"directory": 2026}, where="x")
