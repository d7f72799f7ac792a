"""Which winch: what a larger one gains in workable seas, where more gains little, and what an hour asks of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import pandas
from cable_sim_node.vertical.axial_line import axial_line
from heave_node.kpi import RATED_SHARE
from heave_node.loads.cycles import DAMAGE_EXPONENT, LEAST_RANGE

from heave_studies.answers.answer import (
    Ask,
    Found,
    Section,
    check_seas,
    criteria_of,
    criteria_section,
    first_scenario,
)
from heave_studies.sizing import (
    ABILITY,
    BUYERS,
    DUTY,
    ENOUGH,
    KNEES,
    OF_THE_WINCH,
    PARTICULARS,
    Sized,
    as_link,
    candidates,
    even_seas,
    knees,
    own_winch,
    size_winches,
    sweep_figure,
)
from heave_studies.study.plan import Study
from heave_studies.study.summary import FEWEST_SEEDS
from heave_studies.study.workers import FAILURE

KEYS: Mapping[str, object] = MappingProxyType(dict.fromkeys((one.name for one in PARTICULARS), None))
"""Values to be tried of each particular (SI; none: shares of the scenario's)."""

FOOTER = f"""Workable: within the largest sea in which the criteria hold, a mean over the seeds, linear between the seas
that were run. An hour's figures are means over the workable seas of each winch, so that a winch which works in higher
seas is charged with them. Bending cycles: of the piece of rope that is bent most, on one sheave whose arc of contact is
longer than the stroke; count each further sheave. Tension cycles: rainflow count of the top tension (ASTM E1049-85),
ranges of at least {100 * LEAST_RANGE:g} % of its mean. Equivalent tension range: the one that once a second does the
damage of all cycles, by Miner's sum with m = {DAMAGE_EXPONENT:g} (stranded steel wire rope in tension, DNV-OS-E301 Ch.2
Sec.2). Above half rating: more than {100 * RATED_SHARE:g} % of the winch's speed or power."""


def prepare(study: Study, ask: Ask, /) -> Study:
    """See `heave_studies.answers.answer.Answer`: adds the winches that are tried."""
    check_seas(study, OF_THE_WINCH)
    parameters = first_scenario(study).parameters
    winch, plant = parameters["virtual_winch"], parameters["cable_sim"]
    static_tension = axial_line(plant, plant.boom_tip_height).static_top_tension(plant.length)
    tried = candidates(own_winch(winch), static_tension, {one.name: _values(ask[one.name]) for one in PARTICULARS})
    return replace(study, vary=(as_link(tried, winch.stop_deceleration), *study.vary))


def _values(given: object) -> list[float] | None:
    return None if given is None else [float(str(one)) for one in (given if isinstance(given, list) else [given])]


def answer(study: Study, frame: pandas.DataFrame, _: Ask, /) -> Found:
    """See `heave_studies.answers.answer.Answer`."""
    criteria = criteria_of(study, OF_THE_WINCH)
    seas = even_seas(frame)
    found = size_winches(frame, criteria[""], seas)
    answers = knees(found)
    knee = f"The knee gives {100 * ENOUGH:g} % of what the best of its sweep gives, all else as the scenario has it."
    sections = [
        Section(notices=_notices(found), in_terminal=False),
        Section("Answer", KNEES.headings, KNEES.cells(answers), words=[f"Seas: {seas.name}. {knee}"]),
        Section("Winches", ABILITY.headings, ABILITY.cells(found)),
        Section("An hour of compensation", DUTY.headings, DUTY.cells(found), words=["Means over the workable seas."]),
        criteria_section(criteria),
        Section(
            "What each particular is worth", figures=[sweep_figure(found, one) for one in answers], in_terminal=False
        ),
    ]
    data = {
        "seas": seas.name,
        "knees": {one.particular.name: {"value": one.value, "is_open": one.is_open} for one in answers},
        "winches": BUYERS.records(found),
    }
    return Found(sections, data, FOOTER, judged=int((frame[FAILURE] == "").sum()))


def _notices(found: Sequence[Sized]) -> list[str]:
    words = []
    if any(one.limit["seeds"].min() < FEWEST_SEEDS for one in found):
        words.append(
            f"Fewer than {FEWEST_SEEDS} seeds show no confidence: differences of a few percent between winches may be "
            "chance."
        )
    if any(one.limit["is_open"].any() for one in found):
        words.append(
            "Some winches work in every sea of the study at some period: their limit lies above its largest height."
        )
    if any(one.limit["is_below"].any() for one in found):
        words.append(
            "Some winches are limited below the smallest height of the study at some period: no sea was run there, and "
            "their limit is estimated, linear from a calm sea on."
        )
    left_out = ", ".join(OF_THE_WINCH)
    words.append(
        "The scenario's criteria on the winch's own limits and power are left out: a winch counts by what it does for "
        f"the unit ({left_out})."
    )
    return words
