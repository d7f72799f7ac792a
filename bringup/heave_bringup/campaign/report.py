"""What a campaign came to: its table and summary for people, and both for a machine."""

from __future__ import annotations

import numpy as np
import pandas
from heave_bags.analyse import kpi_set
from heave_node import kpi
from rich.table import Table

from heave_bringup.campaign.plan import Campaign, Case
from heave_bringup.campaign.table import (
    BASELINE_EFFICIENCY,
    BASELINE_UNKNOWN,
    FAILURE,
    LOST,
    MET,
    MISSED,
    NOMINAL,
    OUTCOME,
    REASON,
    SEED,
    settings_of,
)
from heave_bringup.output import make_table
from heave_bringup.tables.baseline_law import BASELINE_LAW
from heave_bringup.tables.case_table import CASE, FILES, SCENARIO

SHOWN = {
    "unit_sigma_m": "unit",
    "uncompensated_sigma_m": "off",
    "unit_efficiency": "effic.",
    BASELINE_EFFICIENCY: "baseline",
    "max_abs_heave_m": "max",
    "uncompensated_max_abs_heave_m": "off max",
    "rope_safety_factor": "rope",
    "dynamic_amplification": "DAF",
    "uncompensated_dynamic_amplification": "DAF off",
    "tension_min_n": "Tmin",
    "tension_max_n": "Tmax",
    "winch_speed_max_mps": "speed",
    "time_at_limit_percent": "at limit",
}
"""Figures of merit in the table for people, with their headings; all of them are in files."""

SUMMARY = {
    "cases": "cases",
    "failed": "cases that could not be run",
    "lost": "cases in which compensation was lost",
    "met": "cases that met all criteria",
    "unit_sigma_m_median": "unit heave, standard deviation: median of the cases",
    "unit_sigma_m_p90": "90th percentile",
    "unit_sigma_m_max": "largest",
    "unit_sigma_m_nominal": "nominal",
    "p90_over_nominal": "90th percentile over nominal",
    "worse": "largest over uncompensated",
    "snaps": "snaps",
    "snaps_uncompensated": "snaps, uncompensated",
}
"""What the summary shows, by its key in JSON."""

SELDOM_KNOWN = (BASELINE_EFFICIENCY, "rope_safety_factor")
"""Columns that are omitted where no case has a value."""


def to_json(campaign: Campaign, frame: pandas.DataFrame) -> dict[str, object]:
    """Return everything that a campaign gave, for a machine.

    Parameters
    ----------
    campaign : that was run
    frame : a row for each case, as `case_frame` gives it
    """
    return {
        "campaign": str(campaign.path),
        "scenario": campaign.scenario,
        "cases": [_case_content(row, settings_of(frame)) for row in frame.to_dict("records")],
        "summary": summarise(frame),
    }


def _case_content(row: dict[object, object], settings: list[str]) -> dict[str, object]:
    kpis = {key: float(row[key]) for key in kpi_set.DEFINITION_OF}  # type: ignore[arg-type]
    head: dict[str, object] = {name: row[name] for name in (CASE, SEED, NOMINAL)}
    given = {name: row[name] for name in settings if row[name] is not None}
    if row[FAILURE]:
        return {**head, **given, FAILURE: row[FAILURE]}
    outcome = {name: row[name] for name in OUTCOME}
    return {**head, **given, **outcome, **kpi_set.to_json(kpis)}


def summarise(frame: pandas.DataFrame) -> dict[str, float]:
    """Return what the cases of a `frame` come to together, nominal ones apart."""
    drawn = frame[~frame[NOMINAL]]
    good = drawn[drawn[FAILURE] == ""]
    counts = {"cases": float(len(drawn)), "failed": float(len(drawn) - len(good))}
    if good.empty:
        return counts
    unit = good["unit_sigma_m"]
    p90 = float(np.percentile(unit, 90))
    return {
        **counts,
        "lost": float(good[LOST].sum()),
        "met": float(good[MET].sum()),
        "unit_sigma_m_median": float(unit.median()),
        "unit_sigma_m_p90": p90,
        "unit_sigma_m_max": float(unit.max()),
        **_against_nominal(frame, p90),
        "worse": kpi.worse(unit, good["uncompensated_sigma_m"]),
        "snaps": float(good["snaps"].sum()),
        "snaps_uncompensated": float(good["uncompensated_snaps"].sum()),
    }


def _against_nominal(frame: pandas.DataFrame, p90: float) -> dict[str, float]:
    """Return the nominal cases' unit sigma (root mean square) and the others' 90th percentile over it."""
    sigmas = frame.loc[frame[NOMINAL] & (frame[FAILURE] == ""), "unit_sigma_m"]
    if sigmas.empty:
        return {}
    nominal = float(np.sqrt(np.mean(np.square(sigmas))))
    return {"unit_sigma_m_nominal": nominal, "p90_over_nominal": p90 / nominal}


def case_table(frame: pandas.DataFrame) -> Table:
    """Return a row for each case of a `frame`: unit and uncompensated motion, tension, use of the winch."""
    keys = [key for key in SHOWN if key not in SELDOM_KNOWN or frame[key].notna().any()]
    headings = [f"{SHOWN[key]} {kpi_set.DEFINITION_OF[key].unit}".strip() for key in keys]
    columns = ["no.", "case", *headings, "remark"]
    settings = settings_of(frame)
    rows = [_cells(row, settings, keys) for row in frame.to_dict("records")]
    return make_table(columns, rows, texts=["case", "remark"])


def _cells(row: dict[object, object], settings: list[str], keys: list[str]) -> list[str]:
    label = Case(
        int(row[CASE]),  # type: ignore[call-overload]
        int(row[SEED]),  # type: ignore[call-overload]
        {place: row[place] for place in settings},
        bool(row[NOMINAL]),
    ).label
    head = [str(row[CASE]), label]
    if row[FAILURE]:
        return [*head, *[""] * len(keys), f"failed: {row[FAILURE]}"]
    values = {key: float(row[key]) for key in keys}  # type: ignore[arg-type]
    remark = f"lost: {row[REASON]}" if row[LOST] else str(row[MISSED])
    cells = [kpi_set.DEFINITION_OF[key].text(value) for key, value in values.items()]
    return [*head, *cells, remark]


def left_out(frame: pandas.DataFrame) -> list[str]:
    """Return the line below the table of a `frame` that says where, and why, the baseline is not in it; or none."""
    unknown = frame[frame[BASELINE_UNKNOWN] != ""]
    if len(unknown):
        some = f"of {len(unknown)} of {len(frame)} cases is unknown; case {unknown[CASE].iloc[0]}"
        which = "is unknown" if len(unknown) == len(frame) else some
        return [f"the baseline {which}: {unknown[BASELINE_UNKNOWN].iloc[0]}"]
    if frame[BASELINE_EFFICIENCY].notna().any() or (frame[FAILURE] != "").all():
        return []
    return [f"left out: the efficiency of law {BASELINE_LAW} beside each case (--no-baseline)"]


def summary_table(frame: pandas.DataFrame) -> Table:
    """Return what the cases of a `frame` come to together, each in the unit of the table of cases."""
    found = summarise(frame)
    sigma = kpi_set.DEFINITION_OF["unit_sigma_m"]
    rows = []
    for key, words in SUMMARY.items():
        if key in found:
            is_sigma = key.startswith(sigma.key)
            shown = sigma.text(found[key]) if is_sigma else f"{found[key]:.3f}".rstrip("0").rstrip(".")
            rows.append([words, shown, sigma.unit if is_sigma else ""])
    return make_table(["all cases", "value", "unit"], rows, texts=["unit"])


def without_scenario(frame: pandas.DataFrame) -> pandas.DataFrame:
    """Return a `frame` for people's programs: without the text of each scenario and its files."""
    return frame.drop(columns=[SCENARIO, FILES])
