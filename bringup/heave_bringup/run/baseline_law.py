"""The law of which the efficiency is shown beside that of every other."""

from __future__ import annotations

BASELINE_LAW = "industrial"
"""Law of the baseline, by its name in the registry: what makers of winches do."""

LAW = "winch_controller.law"
"""Place of the law among the parameters of a case."""
