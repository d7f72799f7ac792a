"""All nodes in one process: the same protocol, the same end, and one line that says what went wrong first."""

import pytest
from loop_processes import SUM_OF_40_TICKS


def test_a_run_in_one_process_gives_what_it_gives_in_four(loop):
    loop.start("composed")
    status, out, err = loop.end("composed")
    assert (status, err) == (0, "")
    assert f"ended=True ticks=41 epoch=1 sum={SUM_OF_40_TICKS}" in out  # the last tick has no step
    assert "resends=0" in out


def test_a_run_in_one_process_keeps_real_time(loop):
    loop.start("composed", pacing="realtime", strict=False)
    status, out, err = loop.end("composed")
    assert (status, err) == (0, "")
    assert "ended=True ticks=41" in out


@pytest.mark.parametrize("pacing", ["lockstep", "realtime"])
def test_a_node_that_raises_ends_the_others_and_has_the_last_word(loop, pacing):
    loop.start("composed", pacing=pacing, strict=False, **{"virtual_winch:fault": "raise"})
    status, _, err = loop.end("composed")
    assert status == 1
    assert err.splitlines()[-1] == "virtual_winch: the solver gave up at t = 1.000 s"
    assert {line.partition(":")[2].partition(" at t")[0] for line in err.splitlines()[:-1]} == {
        " virtual_winch has failed"
    }
