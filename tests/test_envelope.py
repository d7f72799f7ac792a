"""The envelope in the loop: a fault behind it drives the drum no further than the sea explains.

Without it (`envelope.active` false) a drum under orders 100 times too large travels 1.5 m, and one of a drive 100 times
too quick 2.1 m.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from heave_bringup.closed_loop import COLUMNS, ClosedLoop
from heave_core.envelope_table import Phase

from tests.campaigns.fault_matrix.faults import Fault
from tests.campaigns.fault_matrix.wires import Wires
from tests.core_parts import change_order
from tests.loop_runs import recorded_messages, run_scenario
from tests.loops import fault, loop_of

TICK, AFTER = 0.05, 60.0
"""Tick period, and time that is looked at from the fault on [s]."""


def order_times(factor: float, loop: ClosedLoop) -> None:
    """Let the controller's order, before the envelope, be `factor` times what it means."""

    def times(ordered):
        ordered["rate"] *= factor

    change_order(loop.controller, times)


def on_the_wire(name: str, size: float, loop: ClosedLoop) -> None:
    """Let a drive get other orders than it is sent."""
    Wires(loop, TICK).begin(Fault(name, size))


def nothing(_: ClosedLoop) -> None:
    """The fault is one of the settings."""


CASES: dict[str, tuple[float, Callable[[ClosedLoop], None], float]] = {
    "encoder frozen": (120.0, nothing, 1.2),
    "order x100": (100.0, partial(order_times, 100.0), 0.8),
    "drive x100": (100.0, partial(on_the_wire, "orders factor", 100.0), 0.6),
    "drive x3": (100.0, partial(on_the_wire, "orders factor", 3.0), 0.5),
    "drive reversed": (100.0, partial(on_the_wire, "orders reversed", 0.0), 0.4),
}
"""When [s], what becomes of the loop, and travel from then on [m]: heave of the last minute 0.3 m, 1.5 times that and
0.3 m to either side."""


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_a_fault_drives_the_drum_no_further_than_the_sea_explains(name):
    start, change, furthest = CASES[name]
    settings = fault("encoder", "freeze", start) if name == "encoder frozen" else {}
    loop = loop_of("b2_calm_300", settings, duration=start + AFTER, seed=3 if settings else 1)
    payout, bound = [], 0
    for tick in range(1, round((start + AFTER) / TICK) + 1):
        if tick == round(start / TICK):
            change(loop)
        outputs, row = loop.step()
        payout.append(row[COLUMNS.index("payout")] - loop.controller.mean.point.payout)
        last = loop.controller.envelope.last
        bound += tick * TICK < start and bool(int(last.bits) & 3 or last.phase != Phase.FREE)
    after = np.array(payout)[round(start / TICK) :]
    assert bound == 0, "it does not bind before"
    assert np.max(np.abs(after - after[0])) == pytest.approx(0.0, abs=furthest)
    assert outputs.mode in ("stopped", "standby")


# as a node of its own


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
    written = bounded.parent / "scenario.yaml"
    assert "winch_envelope" in written.read_text(encoding="utf-8"), "among the participants"
    again = recorded_messages(run_scenario(tmp_path / "again", str(written), duration=DURATION, options=["--composed"]))
    assert [m for m in again if m[0].startswith("/winch/")] == [m for m in beside if m[0].startswith("/winch/")]
