"""What a reader of a run must be warned of: parts with a small safety factor, compensation that did harm, that was
seldom active, that others beat.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from heave_node import kpi
from heave_node.interface import topics
from heave_node.interface.alarm import alarms_in
from heave_node.interface.codes import RESTS_REQUESTED, without_figures

from heave_bags.analyse import events
from heave_bags.analyse.run_record import RunRecord
from heave_bags.analyse.verdict import LEAST_SHARE, share_in_force, time_within

NOTABLE = 0.005
"""An efficiency that is lower than another one by less is as good [-]."""
MOST_LISTED = 3
"""Times, reasons or alarms that a warning lists."""
LEAST_OF_WAITS = 0.05
"""A reason that held for a smaller share of the time without compensation is not reported."""
ERROR = 2
"""Level of an alarm that is an error."""
OF_CONTROLLER = f"{topics.CONTROLLER_STATE.publisher}: "
"""Begins the alarms of the controller."""


def warnings(record: RunRecord, values: Mapping[str, float]) -> list[str]:
    """Return which parts of the run `record` are too weak, where its winch did harm, and by its figures of merit,
    `values`, where another law did better.
    """
    weak = [str(check) for check in record.signals.load_checks() if check.is_failed]
    if not record.moves_winch:
        return weak
    unit, outlet, baseline = (values[f"{of}_efficiency"] for of in ("unit", "outlet", "baseline"))
    found = [*weak, *worse_than_off(record), *why_not_in_force(record, values)]
    if unit < -NOTABLE:
        found.append(
            f"The load moved more than with the winch locked (efficiency {_percent(unit)}); the list of events "
            "shows when the winch did not do what was commanded"
        )
    if outlet < -NOTABLE:
        found.append(f"The rope at the boom tip moved more than with the winch locked (efficiency {_percent(outlet)})")
    if unit < baseline - NOTABLE:
        found.append(
            f"The load moved more than under an industrial controller in the same sea (efficiency {_percent(unit)} "
            f"against {_percent(baseline)})"
        )
    return found


def _percent(share: float) -> str:
    """Return a `share` in percent; one that rounds to 0 has no sign."""
    return f"{round(100.0 * share, 1) + 0.0:.1f} %"


@dataclass
class Worse:
    """A time in which the load moved more than with the winch locked, over a window about each moment of it."""

    start: float  # middle of its first window [s]
    end: float  # middle of its last window [s]
    ratio: float  # largest standard deviation over that with the winch locked [-]
    at: float  # middle of that window [s]
    mode: str = ""  # of the controller at that time

    @property
    def most(self) -> str:
        """The worst window in words."""
        return f"worst {self.ratio:.2f}x at {self.at:.0f} s, in {self.mode}"

    def __str__(self) -> str:
        return f"{self.start:.0f} s to {self.end:.0f} s, {self.most}"


def worse_times(record: RunRecord) -> list[Worse]:
    """Return when the load of the run `record` moved more than with the winch locked, since compensation first began.

    That is judged over windows of `kpi.WORSE_WINDOW`, one a second: windows that follow one another are one time.
    """
    unit, off = record.signals.unit_heave, record.signals.uncompensated_heave
    began = next((mode.start for mode in record.modes if mode.name in events.COMPENSATES), math.nan)
    if not (unit.size and off.size and math.isfinite(began)):
        return []
    starts, ratios = kpi.window_ratios(unit.time, unit.value, off.at(unit), began, floor=kpi.WORSE_FLOOR)
    found: list[Worse] = []
    was_worse = False
    for middle, ratio in zip((starts + 0.5 * kpi.WORSE_WINDOW).tolist(), ratios.tolist(), strict=True):
        is_worse = ratio > kpi.WORSE_RATIO
        if is_worse and not was_worse:
            found.append(Worse(middle, middle, 0.0, middle))
        if is_worse:
            last = found[-1]
            last.end = middle
            if ratio > last.ratio:
                last.ratio, last.at, last.mode = ratio, middle, _mode_at(record, middle)
        was_worse = is_worse
    return found


def _mode_at(record: RunRecord, time: float) -> str:
    """Return the mode of the controller at a `time` [s] after its first."""
    return next(mode.name for mode in reversed(record.modes) if mode.start <= time)


def worse_than_off(record: RunRecord) -> list[str]:
    """Return in words when the load of the run `record` moved more than it would have with the winch locked."""
    found = worse_times(record)
    if not found:
        return []
    more = f"; {len(found) - MOST_LISTED} more times" if len(found) > MOST_LISTED else ""
    return [
        f"Load moved more than with the winch locked (rolling {kpi.WORSE_WINDOW:g} s) from "
        f"{'; '.join(map(str, found[:MOST_LISTED]))}{more}"
    ]


def why_not_in_force(record: RunRecord, values: Mapping[str, float]) -> list[str]:
    """Return in words why compensation was seldom active in the run `record`, or never, by its figures of merit,
    `values`, where nobody had asked for that.
    """
    waits = [wait for wait in record.waits if wait.reason not in RESTS_REQUESTED and time_within(record, wait) > 0.0]
    last = record.modes[-1] if record.modes else None
    is_over = last is not None and last.name not in events.COMPENSATES and last.reason not in RESTS_REQUESTED
    is_seldom = share_in_force(record, values) < LEAST_SHARE and (record.is_past_transient or is_over)
    if not waits or not is_seldom:
        return []
    share = values["compensating_percent"]
    how = f"was active for {share:.1f} % of the time" if share > 0.0 else "was never active"
    how += f" from {record.start:.0f} s to {record.end:.0f} s"
    if not any(mode.name in events.COMPENSATES for mode in record.modes):
        how = "never began"
    alarms = [one.name for one in record.alarms if one.level == ERROR and one.name.startswith(OF_CONTROLLER)]
    # an alarm whose consequence changes is reported again: its code says enough here
    codes = dict.fromkeys(code for name in alarms for code in [one.code for one in alarms_in(name)] or [name])
    raised = f". Alarms: {'; '.join(list(codes)[:MOST_LISTED])}" if codes else ""
    return [f"Compensation {how}. Reasons: {'; '.join(_reasons(record, waits))}{raised}"]


def _reasons(record: RunRecord, waits: list[events.Interval]) -> list[str]:
    """Return for how long compensation was not active for which reason, the longest first."""
    spent: dict[str, float] = {}
    words: dict[str, str] = {}
    for wait in waits:
        kind = f"{wait.name}: {without_figures(wait.reason)}"
        words[kind] = f" ({wait.reason})" if wait.reason else ""
        spent[kind] = spent.get(kind, 0.0) + time_within(record, wait)
    least = LEAST_OF_WAITS * sum(spent.values())
    longest = sorted((kind for kind in spent if spent[kind] >= least), key=lambda kind: -spent[kind])
    return [f"{kind.partition(':')[0]} for {spent[kind]:.0f} s{words[kind]}" for kind in longest[:MOST_LISTED]]
