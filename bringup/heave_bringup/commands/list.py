"""`heave list`: the shipped scenarios."""

from __future__ import annotations

import argparse

from heave_bringup.output import write_result
from heave_bringup.scenarios import description_of, shipped_scenarios


def execute(options: argparse.Namespace) -> None:
    """Print name and description of each scenario."""
    scenarios = {name: description_of(path) for name, path in shipped_scenarios().items()}
    width = max(map(len, scenarios), default=0)
    text = "\n".join(f"{name.ljust(width)}  {description}" for name, description in scenarios.items())
    write_result(options, text, scenarios)
