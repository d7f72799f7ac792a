"""Parameters of a run: what is external, and how it stamps."""

import pytest
from heave_node.interface import topics
from heave_node.interface.sensors import LOAD_CELL, MRU
from heave_node.parameters import ParameterError, build_parameters
from heave_node.run_parameters import REALTIME, RunParameters
from heave_node.tick.clock_rule import ClockRule


def test_a_topic_is_external_by_its_node_or_by_itself_and_its_clock_is_declared_for_either():
    run = RunParameters(
        pacing=REALTIME,
        external=("virtual_winch", "winch/load_cell"),
        external_clocks=("virtual_winch=own", "winch/load_cell=none:0.04"),
    )
    external = {topic.name for topic in topics.ALL_TOPICS if run.is_external(topic)}
    assert "winch/load_cell" in external
    assert topics.WINCH_STATE.name in external
    assert external.isdisjoint({"mru", "unit/pressure", "cable/state"}), "of nodes that stay"
    assert run.stamping(topics.WINCH_STATE) == (ClockRule.OWN, 0.0)
    assert run.stamping(LOAD_CELL.topic) == (ClockRule.NONE, 0.04)
    assert run.stamping(MRU.topic) == (ClockRule.DETECT, 0.0)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"external": ["virtual_winch"]}, "needs pacing: realtime"),
        ({"realtime_priority": 50}, "needs pacing: realtime"),
        ({"external_clocks": ["virtual_winch=own"]}, "external_clocks names virtual_winch, which is not external"),
        ({"duration": 0.01}, "must be at least one tick of 0.05 s"),
    ],
)
def test_parameters_of_a_run_that_contradict_one_another_are_refused(values, words):
    with pytest.raises(ParameterError, match=words):
        build_parameters(RunParameters, values, where="")
