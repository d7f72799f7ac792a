"""The envelope as a node between controller and winch: inside its bounds the run is the same, byte for byte."""

import pytest

from tests.loop_runs import recorded_messages, run_scenario

DURATION = 32.0
"""It compensates from 24 s on [s]."""

OF_THE_LOOP = ("/winch/command", "/winch/state", "/cable/state", "/controller/state")


@pytest.mark.slow
def test_a_winch_behind_the_envelope_gets_the_orders_of_the_controller_and_the_loop_is_the_same(tmp_path):
    plain = run_scenario(tmp_path / "plain", duration=DURATION, options=["--composed"])
    bounded = run_scenario(tmp_path / "bounded", duration=DURATION, options=["--composed", "--envelope"])
    alone, beside = recorded_messages(plain), recorded_messages(bounded)
    ordered, within = ([m[1:] for m in beside if m[0] == f"/winch/{name}"] for name in ("command", "command_within"))
    assert len(ordered) > 600
    assert within == ordered
    for topic in OF_THE_LOOP:
        assert [m for m in beside if m[0] == topic] == [m for m in alone if m[0] == topic], topic
