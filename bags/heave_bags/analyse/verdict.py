"""The verdict on a run: its criteria, the values reached, how long compensation was active, alarms."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from heave_node.criteria import Criterion
from heave_node.interface.codes import RESTS_REQUESTED
from heave_node.loads.strength import ROPE, LoadCheck
from heave_node.numerics.constants import LARGEST_STRAIN

from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.kpis.definition import KpiDefinition

if TYPE_CHECKING:
    from heave_bags.analyse.events import Interval
    from heave_bags.analyse.run_record import RunRecord

LEAST_SHARE = 0.9
"""Compensation that was active for a smaller share of the evaluation window is worth a line of its own."""

FAILED, PASSED, NO_VERDICT = "FAILED", "passed", "none"
"""Verdicts."""

LEAST_WINDOW = 60.0
"""A run is judged if its figures cover at least this [s]: some six waves."""

MOVED_BY_COMMANDS = ("cable_sim", "virtual_winch")
"""Nodes whose figures are those of the controller under test; played from a bag, they are those of another run."""

NO_ROPE = "Rope strength not stated: not judged (system.cable.breaking_force)"
"""Remark on a lift whose rope has no safety factor."""

RELATIONS = {"<=": "at most", "<": "below", ">=": "at least", ">": "above"}
"""The relations of criteria in words."""


def required_words(criterion: Criterion, definition: KpiDefinition | None = None) -> str:
    """Return what a `criterion` requires, in the unit in which tables show its figure: at most 5 cm.

    `definition` is that of the figure; None: it is one of a run.
    """
    definition = definition or DEFINITION_OF.get(criterion.kpi)
    bound = definition.bound(criterion.bound) if definition else f"{criterion.bound:.6g}"
    return f"{RELATIONS[criterion.relation]} {bound}"


@dataclass(frozen=True)
class Judged:
    """A criterion and the value that a run reached; NaN: not known. `known` defines a figure of another table."""

    criterion: Criterion
    value: float
    known: KpiDefinition | None = None

    @property
    def definition(self) -> KpiDefinition | None:
        """Definition of the figure; None: there is none."""
        return self.known or DEFINITION_OF.get(self.criterion.kpi)

    @property
    def is_met(self) -> bool:
        """Return whether the value keeps the bound."""
        return self.criterion.is_met(self.value)

    def to_json(self) -> dict[str, object]:
        """Return it as plain data."""
        criterion = self.criterion
        plain = {"kpi": criterion.kpi, "wanted": criterion.text, "got": self.value, "met": self.is_met}
        return {**plain, "words": str(self)}

    def __str__(self) -> str:
        """Return figure, value and bound in the unit of the tables, and whether it is met."""
        definition = self.definition
        name = definition.title if definition else self.criterion.kpi
        state = "met" if self.is_met else FAILED
        required = required_words(self.criterion, self.known)
        return f"{name[0].upper()}{name[1:]} {self.got} (required {required}): {state}"

    @property
    def got(self) -> str:
        """The value as tables show it, with more digits where these would not tell it from the bound it misses."""
        definition = self.definition
        if definition is None:
            return f"{self.value:.4g}"
        if not math.isfinite(self.value):
            return f"unknown, it needs {definition.needs}" if definition.needs else "unknown"
        shown = definition.text(self.value)
        if not self.is_met and self.criterion.is_met(float(shown) / definition.scale):
            return definition.bound(self.value)
        return f"{shown} {definition.unit}".rstrip()


@dataclass(frozen=True)
class Verdict:
    """What became of a run."""

    judged: tuple[Judged, ...]  # the criteria of the scenario
    required: tuple[Judged, ...]  # those of the command line
    # share of the evaluation window in each mode of the controller, 0 to 1; empty: none was recorded
    time_in_modes: Mapping[str, float]
    # of the evaluation window in which compensation was active, 0 to 1, not counting the time in which it rested since
    # somebody had asked for that [-]; NaN: unknown, or not required
    share: float
    alarms: int = 0  # number of errors that came
    why_not_judged: str = ""  # in words; "": it is judged
    strain: float = math.nan  # largest of the cable in the whole run [-]; NaN: unknown
    # how the parts whose strength is stated stood under their largest load of the whole run
    loads: tuple[LoadCheck, ...] = ()
    has_rope: bool = True  # the strength of the rope is stated
    sea: str = ""  # that was run: its seed, or where it comes from; "": unknown
    is_whole: bool = True  # no message of the run was lost

    @property
    def criteria(self) -> list[Judged]:
        """Return all criteria, one that the scenario and the command line both have once."""
        return list(dict.fromkeys((*self.judged, *self.required)))

    @property
    def is_good(self) -> bool:
        """Return whether every criterion is met and there is no breach."""
        return not self.failures

    @property
    def breaches(self) -> list[str]:
        """Return in words what fails any run: a part too weak, a cable strained too much, compensation inactive."""
        found = [str(check) for check in self.loads if check.is_failed]
        if self.strain > LARGEST_STRAIN:
            found.append(
                f"Largest strain of the cable {100.0 * self.strain:.3g} % (required at most "
                f"{100.0 * LARGEST_STRAIN:.0f} %): the rope would have parted: FAILED"
            )
        if self.share < LEAST_SHARE:
            modes = ", ".join(
                f"{mode} {100.0 * share:.0f} %" for mode, share in self.time_in_modes.items() if share > 0.005
            )
            found.append(f"{self._active}{FAILED}" + (f" (modes: {modes})" if modes else ""))
        return found

    @property
    def _active(self) -> str:
        """How long compensation was active, and what is required."""
        share, least = 100.0 * self.share, 100.0 * LEAST_SHARE
        return f"Compensation active {share:.0f} % of the time (required at least {least:.0f} %): "

    @property
    def failures(self) -> list[str]:
        """Return in words the breaches, and which criteria are not met."""
        return [*self.breaches, *(str(judged) for judged in self.criteria if not judged.is_met)]

    @property
    def state(self) -> str:
        """The verdict in a word: FAILED, passed, or none."""
        if self.failures:
            return FAILED
        return PASSED if (self.criteria or self.loads) and not self.why_not_judged else NO_VERDICT

    def lines(self) -> list[str]:
        """Return the verdict for people: one word, then each criterion and each part under load."""
        if self.state == FAILED:
            head = f"verdict: {FAILED}"
        elif self.why_not_judged:
            judged = [*(["--require"] if self.criteria else []), *(["strength"] if self.loads else [])]
            what = f"verdict on {' and '.join(judged)} only" if judged else "no verdict"
            head = f"{what}: {self.why_not_judged}"
        elif self.state == PASSED:
            head = f"verdict: {PASSED}" + (f" for one sea, {self.sea}" if self.sea else "")
        else:
            head = "verdict: no criteria given"
        if self.alarms:
            head += f"; {self.alarms} {'error' if self.alarms == 1 else 'errors'} reported"
        head += "" if self.is_whole else "; not all of the bag could be read"
        met = [str(judged) for judged in self.criteria if judged.is_met]
        met += [f"{self._active}met"] if self.share >= LEAST_SHARE else []
        loads = [str(check) for check in self.loads if not check.is_failed]
        return [head, *(f"  {line}" for line in (*self.failures, *met, *loads, *self.remarks))]

    @property
    def remarks(self) -> list[str]:
        """Return in words what could not be judged."""
        return [] if self.has_rope else [NO_ROPE]

    def to_json(self) -> dict[str, object]:
        """Return the verdict as plain data."""
        return {
            "good": self.is_good,
            "state": self.state,
            "criteria": [judged.to_json() for judged in self.criteria],
            "loads": [check.to_json() for check in self.loads],
            "time_in_modes": dict(self.time_in_modes),
            "failures": self.failures,
        }


def judge(
    record: RunRecord,
    wanted: Sequence[Criterion] = (),
    *,
    required: Sequence[Criterion] = (),
    moves_winch: bool,
    alarms: int = 0,
) -> Verdict:
    """Judge a run against its criteria.

    Parameters
    ----------
    record : of the run
    wanted, required : criteria of the scenario and of the command line
    moves_winch : the scenario has a law that moves the winch
    alarms : number of errors that the nodes reported
    """
    values = record.kpis()

    def held(criteria: Sequence[Criterion]) -> tuple[Judged, ...]:
        return tuple(Judged(criterion, values.get(criterion.kpi, math.nan)) for criterion in criteria)

    is_open_loop, why_not = open_loop(record.played), why_not_judged(record)
    return Verdict(
        held(() if why_not else wanted),
        held(required),
        time_in_modes(record),
        share_in_force(record, values) if moves_winch and not why_not else math.nan,
        alarms,
        why_not,
        math.nan if is_open_loop else record.largest_strain,
        () if is_open_loop else record.signals.load_checks(),
        any(one.key == ROPE for one in record.signals.strengths),
        record.sea_run,
        all(loss.messages == 0 for loss in record.losses),
    )


def why_not_judged(record: RunRecord) -> str:
    """Return why the run `record` is not judged by the criteria of its scenario; "" where they do."""
    return open_loop(record.played) or too_short(record.judged_time)


def open_loop(played: Sequence[str]) -> str:
    """Return why a run in which the nodes `played` come from a bag is not judged; "" where commands move the winch."""
    nodes = [node for node in MOVED_BY_COMMANDS if node in played]
    if not nodes:
        return ""
    what = " and ".join(nodes)
    return f"open loop: the figures are those of the recorded {what}, which no command moved"


def too_short(window: float) -> str:
    """Return why a run whose figures cover a `window` [s] after its transient is not judged; "" where they suffice."""
    if window > LEAST_WINDOW - 0.5:  # the record of a run may end a few samples before the run
        return ""
    after = f"only {window:.0f} s" if window > 0.0 else "no time"
    return f"{after} after the transient, a verdict needs {LEAST_WINDOW:g} s"


def judge_loads(loads: Sequence[LoadCheck]) -> Verdict:
    """Return the verdict on parts under their largest `loads` alone, of a lift at rest or a design."""
    known = tuple(check for check in loads if not math.isnan(check.load))
    has_rope = any(check.strength.key == ROPE for check in loads)
    return Verdict((), (), {}, math.nan, loads=known, has_rope=has_rope)


def share_in_force(record: RunRecord, values: Mapping[str, float]) -> float:
    """Return the share of the time in which compensation was active, of that in which nobody wanted it to rest, of the
    run `record` with its figures of merit, `values`.
    """
    rested = sum(time_within(record, mode) for mode in record.modes if mode.reason in RESTS_REQUESTED)
    span = record.end - record.start
    left = 1.0 - rested / span if span > 0.0 else 0.0
    return values["compensating_percent"] / 100.0 / left if left > 0.0 else math.nan


def time_in_modes(record: RunRecord) -> dict[str, float]:
    """Return the share of the evaluation window of `record` that the controller spent in each mode, the largest first.

    Empty where no mode is known.
    """
    shares: dict[str, float] = {}
    for mode in record.modes:
        part = time_within(record, mode)
        if part > 0.0:
            shares[mode.name] = shares.get(mode.name, 0.0) + part
    total = record.end - record.start
    return {name: part / total for name, part in sorted(shares.items(), key=lambda item: -item[1])}


def time_within(record: RunRecord, mode: Interval) -> float:
    """Return how long a `mode` held within the evaluation window of `record` [s]."""
    return max(min(mode.end, record.end) - max(mode.start, record.start), 0.0)
