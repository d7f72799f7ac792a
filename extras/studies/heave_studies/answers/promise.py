"""Whether the promise "never worse than off" holds over its draws, by law; what each part of the controller saves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
import pandas

from heave_studies.answers.answer import Found, Section
from heave_studies.promise.study import Promise
from heave_studies.study.case_file import CASE
from heave_studies.study.summary import wilson
from heave_studies.study.workers import FAILURE

LIMITS = (1.05, 1.2, 1.5)
"""Worst minutes over winch locked that shares are counted of [-]."""
PROMISED: Mapping[str, Mapping[float, float]] = {
    "stacked": {1.05: 0.85, 1.5: 0.97},
    "": {1.05: 0.97, 1.2: 0.995},
}
"""Share of the judged draws within each limit, by kind; the empty one stands for all others."""
SELDOM = 0.01
"""Share of the draws in which a healthy part may be blamed, and in which compensation may never begin for no reason."""
CHANGED = 0.1
"""Difference of a worst minute over winch locked from which on a draw counts as changed [-]."""

Figures = Mapping[str, float]
"""Figures of a kind, by their names in `ROWS`."""


def figures_of(frame: pandas.DataFrame) -> dict[str, float]:
    """Return the distribution of what the draws in a `frame` came to."""
    ran = frame[frame[FAILURE] == ""]
    judged, waited = ran[ran["worst"].notna()], ran[ran["worst"].isna()]
    ratios = judged["worst"].to_numpy(dtype=float)
    alarmed = ran["alarmed"]
    return {
        "draws": len(frame),
        "failed": len(frame) - len(ran),
        "judged": len(judged),
        "p50": _percentile(ratios, 50.0),
        "p90": _percentile(ratios, 90.0),
        "largest": _percentile(ratios, 100.0),
        **{f"within {limit:g}": float(np.mean(ratios <= limit)) if ratios.size else math.nan for limit in LIMITS},
        "never begun": len(waited),
        "without a true reason": int((~waited["has_true_reason"].astype(bool)).sum()),
        "given up": int((ran["given_up"] > 0).sum()),
        "lost": int(ran["is_lost"].sum()),
        "named": int((ran["right"] != "").sum()),
        "blamed": int((ran["wrong"] != "").sum()),
        "reached 1.5": int((alarmed != "").sum()),
        "without an alarm": int((alarmed == "no").sum()),
        "efficiency": _percentile(ran["efficiency"].to_numpy(dtype=float), 50.0),
    }


def _percentile(values: np.ndarray, percent: float) -> float:
    values = values[np.isfinite(values)]
    return float(np.percentile(values, percent)) if values.size else math.nan


def broken(kind: str, found: Figures) -> list[str]:
    """Return which parts of the promise the figures `found` of a `kind` break, in words; empty: it is kept."""
    words = [
        f"{100 * found[f'within {limit:g}']:.1f} % within {limit:g}, promised {100 * share:g} %"
        for limit, share in PROMISED.get(kind, PROMISED[""]).items()
        if not found[f"within {limit:g}"] >= share
    ]
    if kind == "stacked":
        words += [f"{found['without an alarm']:g} reached 1.5 without an alarm"] if found["without an alarm"] else []
    else:
        words += [f"{found['lost']:g} lost"] if found["lost"] else []
        words += [f"{found['blamed']:g} with a healthy part blamed"] if _is_often(found, "blamed") else []
    if _is_often(found, "without a true reason"):
        words.append(f"{found['without a true reason']:g} never begun without a true reason")
    return words + ([f"{found['failed']:g} could not be run"] if found["failed"] else [])


def _is_often(found: Figures, name: str) -> bool:
    return found[name] > SELDOM * found["draws"]


SHARES = tuple(f"within {limit:g}" for limit in LIMITS)
RATIOS = ("p50", "p90", "largest")
ROWS: Mapping[str, str] = {
    "draws": "draws",
    "failed": "draws that could not be run",
    "judged": "draws that were judged",
    **dict(zip(RATIOS, ("worst minute over winch locked: median", "90th percentile", "largest"), strict=True)),
    **{name: f"share {name} (90 % confidence) [%]" for name in SHARES},
    "never begun": "compensation never began",
    "without a true reason": "of these without a true reason",
    "given up": "given up at least once",
    "lost": "lost at the end",
    "named": "a part that differs is named",
    "blamed": "a healthy part is blamed",
    "reached 1.5": "reached 1.5",
    "without an alarm": "of these without an alarm before",
    "efficiency": "efficiency, median [%]",
}
"""Rows of the table, by their names in the figures."""


def figure_rows(found: Mapping[str, Figures]) -> tuple[list[str], list[list[str]]]:
    """Return head and rows of the figures `found`, a column for each name."""
    rows = [[words, *(_text(name, of) for of in found.values())] for name, words in ROWS.items()]
    return ["figure", *found], [row for row in rows if set(row[1:]) != {"-"}]


def _text(name: str, found: Figures) -> str:
    value = found[name]
    if not math.isfinite(value):
        return "-"
    if name in SHARES:
        low, high = wilson(round(value * found["judged"]), int(found["judged"]))
        return f"{100 * value:.1f} ({100 * low:.0f} to {100 * high:.0f})"
    return f"{value:.3f}" if name in RATIOS else f"{100 * value:.1f}" if name == "efficiency" else f"{value:g}"


def ratios_of(frame: pandas.DataFrame) -> pandas.Series:
    """Return the worst minute over winch locked of each draw in a `frame` [-], by its number; 1 of one not judged.

    Such a draw left the unit as it was.
    """
    return frame.set_index("index")["worst"].fillna(1.0)


def changes(before: pandas.DataFrame, now: pandas.DataFrame) -> pandas.DataFrame:
    """Return the draws of both frames that differ by more than CHANGED: columns before, now; the largest change first.

    Parameters
    ----------
    before, now : of the same draws
    """
    both = pandas.DataFrame({"before": ratios_of(before), "now": ratios_of(now)}).dropna()
    step = (both["now"] - both["before"]).abs()
    return both[step > CHANGED].loc[step[step > CHANGED].sort_values(ascending=False).index]


def ablation_rows(frame: pandas.DataFrame) -> tuple[list[str], list[list[str]]]:
    """Return head and rows of what each part of the controller saves and costs in the draws of a `frame`.

    Saves: draws that are worse without it by more than CHANGED; costs: those that are better without it.
    """
    head = ["without", "saves", "costs", "within 1.05 [%]", "within 1.5 [%]", "largest", "lost", "blamed", "no alarm"]
    whole, rows = frame[frame["without"] == ""], []
    for name, part in frame.groupby("without", sort=False):
        found, pairs = figures_of(part), changes(whole, part)
        saves = int((pairs["now"] > pairs["before"]).sum())
        shares = [f"{100 * found[share]:.1f}" for share in ("within 1.05", "within 1.5")]
        counts = [f"{found[key]:g}" for key in ("lost", "blamed", "without an alarm")]
        rows.append([str(name) or "nothing", f"{saves}", f"{len(pairs) - saves}", *shares,
                     f"{found['largest']:.3f}", *counts])  # fmt: skip
    return head, rows


KEYS: Mapping[str, object] = MappingProxyType({"seed": None, "only": None, "without": None})
"""Seed of the draws (none: of the day), numbers of single draws, parts that are switched off one at a time (or all)."""
FOOTER = (
    "Each draw is 390 s. The worst minute begins 30 s after compensation did. 30 s after a fault begins or ends, and a "
    "requested stop, are not judged. A draw that was never judged left the load as it was."
)
SHOWN = 8
"""Worst draws that are listed."""


def answer(kind: Promise, frame: pandas.DataFrame) -> Found:
    """Return the answer that the table of the draws, the `frame` of a study of this `kind`, gives."""
    whole = frame[frame["without"] == ""]
    found = {"all": figures_of(whole), **{str(law): figures_of(part) for law, part in whole.groupby("law")}}
    breaches = broken(kind.kind, found["all"])
    worst = whole.dropna(subset="worst").sort_values("worst", ascending=False).head(SHOWN)
    rows = [[str(row[CASE]), f"{row['worst']:.3f}", row["words"]] for row in worst.to_dict("records")]
    tables = [
        ("Promised", ["worst minute, at most", "share of the draws [%]"], _promised(kind)),
        (f"Seed {kind.seed}", *figure_rows(found)),
        ("Worst draws", ["case", "worst minute", "draw"], rows),
    ]
    waiting, failed = whole[(whole["worst"].isna()) & (whole[FAILURE] == "")], whole[whole[FAILURE] != ""]
    for title, why, part in (("Never judged", "reason", waiting), ("Not run", FAILURE, failed)):
        cells = [[str(row[CASE]), row[why], row["words"]] for row in part.to_dict("records")]
        tables.append((title, ["case", "why", "draw"], cells))
    if kind.without:
        tables.append(("What each part saves", *ablation_rows(frame)))
    verdict = f"verdict: {'FAILED' if breaches else 'passed'}: {'; '.join(breaches) or 'the promise is kept'}"
    sections = [
        Section(title, head, cells, texts=1 + ("why" in head), last_is_text="draw" in head[1:])
        for title, head, cells in tables
        if cells
    ]
    data = {"kind": kind.kind, "seed": kind.seed, "figures": found, "broken": breaches}
    return Found([*sections, verdict], data, FOOTER, breaches, int(found["all"]["judged"]))


def _promised(kind: Promise) -> list[list[str]]:
    promised = PROMISED.get(kind.kind, PROMISED[""])
    return [[f"{limit:g} times winch locked", f"{100 * share:g}"] for limit, share in promised.items()]
