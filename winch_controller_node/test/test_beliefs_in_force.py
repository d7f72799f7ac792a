"""An answer of the adviser becomes active so long after it was asked for, and changes what one table says."""

import dataclasses
import math
import types
from collections import deque
from functools import partial
from types import MappingProxyType, SimpleNamespace

import numpy as np
import pytest
from heave_core.law import put
from heave_core.law_table import ACTIVE_WINCH
from heave_core.library import dtype_of
from winch_controller_node.adviser.component import Adviser
from winch_controller_node.beliefs.beliefs import (
    LATENCY,
    USED,
    Adopted,
    Belief,
    Beliefs,
    EncoderScale,
    Finding,
    parameters_under,
)
from winch_controller_node.beliefs.quantities import with_value
from winch_controller_node.core.component import WinchController
from winch_controller_node.core.restarts import MEMORIES, RESTARTS, Event, restart
from winch_controller_node.core.supervision.rolling_kpi import KpiWindow
from winch_controller_node.design.design import design_controller
from winch_controller_node.interface.readings import Measurements
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.laws.registry import LAWS
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import SeaModelParameters, WinchModelParameters

from tests.core_parts import add_to_window

DT = 0.05
AFTER = round(LATENCY / DT)
NOMINAL = WinchControllerParameters()
ACTIVE = dtype_of(ACTIVE_WINCH)


def made():
    return WinchController(NOMINAL, tick_period=DT)


def stepped(controller, first, last):
    """Step through ticks in which nothing is read; return all alarms."""
    return [alarm for tick in range(first, last + 1) for alarm in controller.step(tick, Measurements()).alarms]


def answer(asked, values=(), *, number=1, is_designed=False, is_adopted=False, nominal=NOMINAL, **other):
    held = {name: Belief(name, value) for name, value in dict(values).items()}
    beliefs = Beliefs(asked, number, MappingProxyType(held), **other)
    design = design_controller(parameters_under(beliefs, nominal), tick_period=DT) if is_designed else None
    adopted = None
    if is_adopted:
        model = design or design_controller(nominal, tick_period=DT)
        adopted = Adopted(asked, np.zeros(model.model.order), model.initial_covariance)
    return dataclasses.replace(beliefs, design=design, adopted=adopted)


@pytest.mark.parametrize("given_after", [1, 7, AFTER - 1])
def test_what_is_asked_at_a_tick_is_in_force_exactly_so_long_after_it_whenever_the_answer_came(given_after):
    controller, asked = made(), 30
    stepped(controller, 1, asked + given_after)
    assert controller.take(answer(asked, {"winch.speed_gain": 0.8}))
    stepped(controller, asked + given_after + 1, asked + AFTER - 1)
    assert controller.beliefs.number == 0
    assert controller.parameters.winch.speed_gain == 1.0
    stepped(controller, asked + AFTER, asked + AFTER)
    assert controller.beliefs.number == 1
    assert controller.parameters.winch.speed_gain == 0.8


def test_an_answer_that_comes_late_is_refused_and_counted():
    controller, asked = made(), 10
    stepped(controller, 1, asked + AFTER - 1)
    assert controller.take(answer(asked, {"winch.speed_gain": 0.8}))
    stepped(controller, asked + AFTER, asked + AFTER)
    assert controller._beliefs.refused == 0
    assert not controller.take(answer(asked, {"winch.speed_gain": 0.5}, number=2))
    stepped(controller, asked + AFTER + 1, asked + 3 * AFTER)
    assert controller._beliefs.refused == 1
    assert controller.parameters.winch.speed_gain == 0.8


def test_what_an_answer_found_that_came_late_is_told_with_the_next_one_once():
    """Its value is in each later answer, so that it was used; that it was found stood in the late one alone."""
    controller, asked = made(), 10
    finding = Finding("differs", "winch.speed_gain", 0.8, "", 1.0)
    stepped(controller, 1, asked + AFTER)
    assert not controller.take(answer(asked, {"winch.speed_gain": 0.8}, findings=(finding,)))
    for number, told in ((2, 1), (3, 0)):
        asked += AFTER
        assert controller.take(answer(asked, {"winch.speed_gain": 0.8}, number=number))
        alarms = stepped(controller, asked + 1, asked + AFTER)
        assert [alarm.name for alarm in alarms].count("WINCH_MODEL_UPDATED") == told


def test_what_a_late_answer_found_is_not_told_once_the_adviser_is_contradicted():
    controller, asked = made(), 10
    assert controller.take(answer(0, {"winch.speed_gain": 0.9}))
    stepped(controller, 1, asked + AFTER)
    late = answer(asked, {"winch.speed_gain": 0.8}, findings=(Finding("differs", "winch.speed_gain", 0.8, "", 1.0),))
    assert not controller.take(late)
    assert controller.take(answer(asked + AFTER, {"winch.speed_gain": -1.0}, number=2))
    alarms = stepped(controller, asked + AFTER + 1, asked + 3 * AFTER)
    assert [alarm.name for alarm in alarms] == ["ADVISER_WRONG: set aside"]


def test_an_answer_that_tells_nothing_new_changes_nothing_and_findings_are_told_once():
    controller = made()
    finding = Finding("differs", "winch.speed_gain", 0.8, "", 1.0)
    controller.take(answer(0, {"winch.speed_gain": 0.8}, findings=(finding,)))
    told = stepped(controller, 1, AFTER)
    design = controller.design
    controller.take(answer(AFTER, {"winch.speed_gain": 0.8}))
    told += stepped(controller, AFTER + 1, 2 * AFTER)
    assert controller.design is design
    assert [alarm.name for alarm in told].count("WINCH_MODEL_UPDATED") == 1


CHANGES = {
    "limits of the winch": {"values": {"winch.speed_out": 1.2, "winch.acceleration_in": 0.9}},
    "gain of the winch": {"values": {"winch.speed_gain": 0.8}},
    "lag of the winch": {"values": {"winch.time_constant": 0.3}, "is_designed": True},
    "sea": {"values": {"sea.peak_period": 11.0}, "is_designed": True},
    "scale of the MRU": {"values": {"mru.scale": 1.3}, "is_adopted": True},
    "high-pass of the MRU": {"values": {"mru.high_pass_period": 30.0}, "is_designed": True, "is_adopted": True},
    "scale of the depth sensor": {"values": {"depth.scale": 0.8}, "is_adopted": True},
    "inertia of the cable": {"values": {"cable.inertia_factor": 1.2}, "is_designed": True, "is_adopted": True},
    "encoder": {
        "values": {"encoder.scale": 0.5},
        "encoder": EncoderScale(5, 0.5, 1.0, 1.0),
        "is_adopted": True,
    },
    "depth sensor left out": {"excluded": "depth", "is_adopted": True},
}

RESET = {
    "limits of the winch": {"drum"},
    "gain of the winch": {"drum"},
    "lag of the winch": {"drum", "carried"},
    "sea": {"carried"},
    "scale of the MRU": {"adopted", "consistency", "guard mru", "sea"},
    "high-pass of the MRU": {"adopted", "consistency", "guard mru", "sea"},
    "scale of the depth sensor": {"adopted", "consistency", "guard depth"},
    "inertia of the cable": {"adopted", "consistency", "guard cable"},
    "encoder": {"adopted", "consistency", "guard encoder", "reflex"},
    "depth sensor left out": {"adopted", "consistency", "guard depth"},
}
"""The policy: what each change restarts, and what becomes of the estimate; guard: of its corrections."""


def spied(controller):
    """Return a set in which all that is reset of a controller is noted."""
    noted = set()
    estimation, winch = controller._estimation, controller._winch

    def spy(holder, method, name):
        was = getattr(holder, method)

        def call(*args, **kwargs):
            noted.add(name(*args) if callable(name) else name)
            return was(*args, **kwargs)

        setattr(holder, method, call)

    spy(estimation, "adopt", "adopted")
    spy(estimation, "carry", "carried")
    spy(estimation, "reset_sea", "sea")
    spy(estimation, "_restart_consistency", "consistency")
    spy(winch.drum, "take", "drum")
    spy(controller._encoder, "restart", "reflex")
    spy(controller._supervisor.guard, "allow_correction", lambda owner, _: f"guard {owner}")
    return noted


@pytest.mark.parametrize("change", CHANGES)
def test_parameters_in_force_are_those_under_the_beliefs_and_what_is_reset_is_what_the_policy_says(change):
    controller, beliefs = made(), answer(10, **CHANGES[change])
    stepped(controller, 1, 10)
    noted = spied(controller)
    assert controller.take(beliefs)
    stepped(controller, 11, 10 + AFTER)
    assert controller.beliefs.number == 1
    noted -= {f"guard {owner}" for owner in ("winch", "sea")}
    assert noted == RESET[change]
    wanted = parameters_under(beliefs, NOMINAL)
    assert controller.parameters.winch == wanted.winch
    assert controller.parameters.sea == wanted.sea
    assert controller.design.parameters == controller.parameters
    assert beliefs.design is None or controller.parameters == wanted
    assert controller.design.limits.speed <= wanted.winch.speed_limit


@pytest.mark.parametrize("change", CHANGES)
def test_an_answer_becomes_active_between_two_ticks_as_it_would_in_the_next_one(change):
    beliefs, settled, unsettled = answer(10, **CHANGES[change]), made(), made()
    for controller in (settled, unsettled):
        stepped(controller, 1, 10)
        assert controller.take(beliefs)
        stepped(controller, 11, 9 + AFTER)
    settled.settle()
    assert (settled.beliefs.number, unsettled.beliefs.number) == (1, 0)
    design = settled.design
    alarms, others = (stepped(controller, 10 + AFTER, 20 + AFTER) for controller in (settled, unsettled))
    assert settled.design is design, "nothing is left to be done in the tick"
    assert alarms == others
    np.testing.assert_array_equal(settled.estimator.estimate, unsettled.estimator.estimate)
    np.testing.assert_array_equal(settled.estimator.covariance, unsettled.estimator.covariance)


def test_an_answer_that_is_due_and_comes_after_the_controller_has_settled_is_active_in_the_tick():
    controller = made()
    stepped(controller, 1, 9 + AFTER)
    controller.settle()
    assert controller.take(answer(10, {"winch.speed_gain": 0.8}))
    stepped(controller, 10 + AFTER, 10 + AFTER)
    assert controller.parameters.winch.speed_gain == 0.8


def test_an_estimate_that_is_adopted_is_followed_up_to_now():
    """Nothing is read and nothing ordered: a state of 20 ticks ago is now A^20 of it."""
    controller = made()
    stepped(controller, 1, 40)
    model = controller.design.model
    x = np.random.default_rng(1).standard_normal(model.order)
    P = controller.design.initial_covariance
    given = dataclasses.replace(answer(40, {"depth.scale": 0.8}), adopted=Adopted(40, x, P))
    assert controller.take(given)
    # a drag goes by the speed of the unit: it is at rest here
    x[model.state("unit_heave_rate")] = 0.0
    stepped(controller, 41, 40 + AFTER)
    wanted = np.linalg.matrix_power(model.A, AFTER) @ x
    waves = [model.state(name) for name in controller.design.sea_states]
    np.testing.assert_allclose(controller.estimator.estimate[waves], wanted[waves], atol=1e-9)


def test_a_sensor_that_is_left_out_is_doubted_and_used_again_with_the_next_answer():
    controller = made()
    controller.take(answer(0, excluded="depth"))
    stepped(controller, 1, AFTER)
    assert controller.observer.excluded == "depth"
    controller.take(answer(AFTER, number=2))
    stepped(controller, AFTER + 1, 2 * AFTER)
    assert controller.observer.excluded == ""


@pytest.mark.parametrize("findings", [(), (Finding("excluded", "mru"),)])
def test_a_sensor_that_is_left_out_is_named_once_whether_the_adviser_reports_it_or_not(findings):
    controller = made()
    controller.take(answer(0, excluded="mru", findings=findings))
    named = [alarm.name for alarm in stepped(controller, 1, AFTER) if alarm.name == "SENSOR_LOST, MRU: excluded"]
    assert named == ["SENSOR_LOST, MRU: excluded"]
    controller.take(answer(AFTER, excluded="mru", number=2))
    assert "SENSOR_LOST, MRU: excluded" not in [alarm.name for alarm in stepped(controller, AFTER + 1, 2 * AFTER)]


@pytest.mark.parametrize("aside", [True, False])
def test_an_encoder_that_a_reflex_sets_aside_is_no_concern_of_an_echo(aside):
    """A second later the adviser says what the core had done: that ends no stop, and sets nothing aside again."""
    controller = made()
    stepped(controller, 1, 10)
    controller.observer.exclude("encoder" if aside else "")
    controller._encoder.state["is_unresolved"] = aside
    for asked, excluded in ((10, "encoder"), (10 + AFTER, "")):
        assert controller.take(answer(asked, excluded=excluded, number=asked))
        stepped(controller, asked + 1, asked + AFTER)
        assert controller.observer.excluded == ("encoder" if aside else "")
        assert controller._encoder.is_unresolved is aside


@pytest.mark.parametrize("law", ["lqg", "mpc"])
def test_the_law_of_another_design_knows_how_near_the_limits_were(law):
    nominal = dataclasses.replace(NOMINAL, law=law)
    controller, asked = WinchController(nominal, tick_period=DT), 30
    before, near = controller._in_force.law, {"is_near": 1, "near_share": 1.4, "freedom": 0.3}
    put(before.core.state, near)
    stepped(controller, 1, asked)
    assert controller.take(answer(asked, {"winch.time_constant": 0.13}, is_designed=True, nominal=nominal))
    stepped(controller, asked + 1, asked + AFTER)
    after = controller._in_force.law
    assert after is not before
    assert {name: after.core.state[name][0] for name in near} == near


def test_limits_are_used_a_little_less_and_need_no_design():
    controller = made()
    law = controller._in_force.law
    controller.take(answer(0, {"winch.speed_in": 1.0}))
    stepped(controller, 1, AFTER)
    assert controller.parameters.winch.speed_limit == USED
    assert controller._in_force.law is law


# after an operator's redesign nobody holds another sea or winch


ATOMS = (str, bytes, int, float, complex, bool, type(None), type, types.ModuleType, types.BuiltinFunctionType)
KEPT = ("_first",)
"""Attributes that redesigns are compared with: the parameters of the start, in the core's beliefs and the adviser."""


def held(root, kind):
    """Return all of a `kind` that can be reached from `root`, with the way to each."""
    found, seen, todo = [], set(), deque([("", root)])
    while todo:
        way, one = todo.popleft()
        if isinstance(one, kind):
            found.append((way, one))
        if isinstance(one, (*ATOMS, np.ndarray, np.generic)) or id(one) in seen:
            continue
        seen.add(id(one))
        if isinstance(one, dict | MappingProxyType):
            parts = [(f"[{key!r}]", value) for key, value in one.items()]
        elif isinstance(one, tuple | list | set | frozenset | deque):
            parts = [(f"[{k}]", value) for k, value in enumerate(one)]
        elif isinstance(one, partial):
            parts = [(".args", one.args), (".keywords", one.keywords)]
        elif isinstance(one, types.FunctionType):
            parts = [(".cell", cell.cell_contents) for cell in one.__closure__ or ()]
        elif isinstance(one, types.MethodType):
            parts = [(".self", one.__self__)]
        else:
            parts = [(f".{name}", value) for name, value in getattr(one, "__dict__", {}).items() if name not in KEPT]
            slots = [name for base in type(one).__mro__ for name in getattr(base, "__slots__", ())]
            parts += [(f".{name}", getattr(one, name)) for name in slots if hasattr(one, name)]
        todo.extend((way + step, value) for step, value in parts)
    return found


def test_the_walk_finds_what_is_hidden():
    sea = NOMINAL.sea
    box = SimpleNamespace(a=[{"b": partial(print, sea)}], c=(lambda: sea,), d=np.zeros(3))
    assert {one for _, one in held(box, SeaModelParameters)} == {sea}
    assert {way.split(".")[1][:1] for way, _ in held(made(), SeaModelParameters)} >= {"_"}


def drawn_redesign(random, nominal):
    """Return other nominal parameters, as an operator may state them: length, sea and swell."""
    values = {
        "length": random.uniform(0.6, 1.5) * nominal.length,
        "sea.significant_wave_height": random.uniform(0.5, 5.0),
        "sea.peak_period": random.uniform(6.0, 15.0),
    }
    for path in random.permutation(list(values))[: random.integers(1, 4)]:
        nominal = with_value(nominal, str(path), float(values[str(path)]))
    return nominal


@pytest.mark.parametrize("seed", range(4))
def test_after_redesigns_nobody_holds_another_sea_or_winch_than_nominal_or_believed(seed):
    """Drawn at random, with beliefs of winch and sea in between: each holder in core and adviser is asked."""
    random, controller = np.random.default_rng(seed), made()
    adviser, tick = Adviser(NOMINAL, tick_period=DT), 1
    nominal = NOMINAL
    for number in range(1, 4):
        values = {
            "winch.speed_gain": float(random.uniform(0.8, 1.2)),
            "winch.speed_in": float(random.uniform(0.8, 1.9)),
        }
        if random.integers(2):
            values |= {"winch.time_constant": 0.25, "sea.peak_period": float(random.uniform(7.0, 14.0))}
        given = answer(tick - 1, values, number=number, is_designed=True, nominal=nominal)
        assert controller.take(given)
        stepped(controller, tick, tick + AFTER)
        tick += AFTER + 1
        nominal = drawn_redesign(random, nominal)
        controller.redesign(nominal)
        observed = None
        for later in range(tick, tick + 2 * AFTER):
            observed = controller.step(later, Measurements()).observations or observed
        tick += 2 * AFTER
        adviser.advise(observed)
        for holder in (controller, adviser):
            seas = {one for _, one in held(holder, SeaModelParameters)}
            assert seas == {nominal.sea}, [way for way, one in held(holder, SeaModelParameters) if one != nominal.sea]
        assert controller.nominal == nominal
        assumed = controller.parameters.winch
        assert assumed == parameters_under(controller.beliefs, nominal).winch
        allowed = {nominal.winch, assumed}
        strange = [way for way, one in held(controller, WinchModelParameters) if one not in allowed]
        assert strange == []
        assert {one for _, one in held(adviser, WinchModelParameters)} == {nominal.winch}


def test_what_an_operator_restates_is_told_to_the_adviser_which_goes_by_it(batch_of):
    nominal = with_value(with_value(NOMINAL, "sea.peak_period", 12.5), "length", 1.2 * NOMINAL.length)
    adviser = Adviser(NOMINAL, tick_period=DT)
    silent = {"brake": 1.0, "encoder": np.nan, "taken": np.nan}
    restated = (("length", nominal.length), ("sea.peak_period", 12.5))
    assert adviser.advise(batch_of(0, **silent)).number == 0
    assert adviser.parameters == NOMINAL
    assert adviser.advise(batch_of(20, restated=restated, epoch=1, **silent)).asked == 39
    assert adviser.parameters == nominal


def test_what_did_not_come_into_force_is_sent_again(batch_of):
    """Beliefs of number 3 are out, the active ones are older: design and state come with the next answer."""
    adviser = Adviser(NOMINAL, tick_period=DT)
    adviser._beliefs = dataclasses.replace(adviser._beliefs, number=3)
    silent = {"brake": 1.0, "encoder": np.nan, "taken": np.nan}
    again = adviser.advise(batch_of(0, beliefs=2, **silent))
    assert again.design is not None
    assert again.number > 3
    assert adviser.advise(batch_of(20, beliefs=again.number, **silent)).design is None


GIVEN = ("._beliefs.nominal", "._beliefs._plain", "._winch.drum._nominal", "._estimation.second.design")
"""Who holds nominal values: their home and design, the drum that is compared with them, and the filter that is."""


def of_winch(limits, winch):
    """Return what the core's record of the active winch has to hold."""
    return {
        "speed": limits.speed,
        "acceleration": limits.acceleration,
        "power": limits.power,
        "lowest": limits.payout_minimum,
        "highest": limits.payout_maximum,
        "least_tension": limits.minimum_tension,
        "most_tension": limits.maximum_tension,
        "static_tension": limits.static_tension,
        "gain": winch.speed_gain,
        "hauling_gain": winch.hauling_gain,
        "creep": winch.creep,
        "linear_step": limits.acceleration * DT / -math.expm1(-DT / winch.time_constant),
    }


@pytest.mark.parametrize("law", LAWS)
def test_whatever_limits_become_active_nobody_goes_by_others(law):
    """Drawn at random, in any order: each holder of a winch or of its limits in the core is asked."""
    random = np.random.default_rng(1)
    nominal = dataclasses.replace(NOMINAL, law=law)
    controller = WinchController(nominal, tick_period=DT)
    for number in range(1, 6):
        tick, names = (
            (number - 1) * (AFTER + 1) + 1,
            ("speed_gain", "speed_in", "speed_out", "acceleration_in", "acceleration_out", "hauling_gain"),
        )
        drawn = {f"winch.{name}": float(random.uniform(0.4, 1.4)) for name in names if random.integers(2)}
        drawn |= {"winch.creep": float(random.uniform(-0.1, 0.1))}
        assert controller.take(answer(tick - 1, drawn, number=number, nominal=nominal))
        stepped(controller, tick, tick + AFTER)
        assumed, limits = controller.parameters.winch, controller.design.limits
        assert assumed == parameters_under(controller.beliefs, nominal).winch
        holders = [
            (way, one)
            for kind in (WinchModelParameters, WinchControllerParameters)
            for way, one in held(controller, kind)
        ]
        others = [way for way, one in holders if getattr(one, "winch", one) != assumed and not way.startswith(GIVEN)]
        others += [way for way, one in held(controller, WinchLimits) if one != limits]
        assert others == []
        records = {one.ctypes.data: one for _, one in held(controller, np.ndarray) if one.dtype == ACTIVE}
        (record,) = records.values()
        for name, value in of_winch(limits, assumed).items():
            assert record[name][0] == pytest.approx(value, nan_ok=True), name


def test_the_share_of_the_unit_follows_the_speed_that_was_learnt():
    """A fifth of the speed limit: it stayed a fifth of the one that was assumed first."""
    controller = WinchController(WinchControllerParameters(law="lqg"), tick_period=DT)
    law = controller._in_force.law
    assert law.core.law["unit_share"] * law.winch.record["speed"] == pytest.approx(0.2 * 2.0)
    controller._in_force.take_limits(dataclasses.replace(controller.parameters.winch, speed_limit=1.0))
    assert law.core.law["unit_share"] * law.winch.record["speed"] == pytest.approx(0.2)


def test_a_window_of_figures_counts_the_limits_of_each_tick():
    """At 0.9 m/s of a winch of 1 m/s no limit is reached; the same rate is above 97 % of one of 0.9 m/s."""
    window = KpiWindow(60.0, tick_period=DT)
    for tick in range(400):
        winch = dataclasses.replace(NOMINAL.winch, speed_limit=1.0 if tick < 300 else 0.9, acceleration_limit=100.0)
        window.take_winch(winch)
        add_to_window(window._ring, 0.0, 0.0, 0.0, 0.0, 0.9, 0.0, 1e4, 0.0)
    assert window.figures().time_at_limit == pytest.approx(0.25)


# the table of restarts


@pytest.mark.parametrize("event", Event)
def test_an_event_restarts_the_memories_of_its_row_in_their_order_and_no_other(event, monkeypatch):
    noted = []
    for memory in MEMORIES:
        monkeypatch.setitem(MEMORIES, memory, lambda core, memory=memory: noted.append((core, memory)))
    core = SimpleNamespace()
    restart(core, event)
    assert noted == [(core, memory) for memory in RESTARTS[event]]


def test_every_memory_has_its_event_and_every_event_its_row():
    assert set(RESTARTS) == set(Event)
    assert {memory for row in RESTARTS.values() for memory in row} == set(MEMORIES)


def test_every_memory_is_one_of_a_controller():
    controller = WinchController(WinchControllerParameters(), tick_period=0.05)
    for event in Event:
        restart(controller, event)
