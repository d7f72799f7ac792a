"""Parameters of a run: what is external, and how it stamps."""

from heave_node.interface import topics
from heave_node.interface.sensors import LOAD_CELL, MRU
from heave_node.run_parameters import REALTIME, RunParameters
from heave_node.tick.clock_rule import ClockRule


def test_a_topic_is_external_by_its_node_or_by_itself_and_its_clock_is_declared_for_either():
    run = RunParameters(
        pacing=REALTIME,
        external=("virtual_winch", "winch/load_cell"),
        external_clocks=("virtual_winch=own", "winch/load_cell=none"),
    )
    external = {topic.name for topic in topics.ALL_TOPICS if run.is_external(topic)}
    assert "winch/load_cell" in external
    assert topics.WINCH_STATE.name in external
    assert external.isdisjoint({"mru", "unit/pressure", "cable/state"}), "of nodes that stay"
    assert run.clock_rule(topics.WINCH_STATE) is ClockRule.OWN
    assert run.clock_rule(LOAD_CELL.topic) is ClockRule.NONE
    assert run.clock_rule(MRU.topic) is ClockRule.DETECT
