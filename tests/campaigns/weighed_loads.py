"""Loads that hang, stand on the bottom or stand on deck: which does the controller take for one that does not hang?

`python -m tests.campaigns.weighed_loads` draws rope, load, sea and a weight that is assumed falsely, runs each case for
45 s, or until a second after compensation has begun, and prints a row of each: a quarter of an hour of processor time.
"""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np
import yaml
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import Scenario, load_scenario

from tests.campaigns.commit import commit_line

CASES = {"hang": 60, "land": 60, "deck": 40}
"""How many are drawn of each kind."""
DURATION, TICK = 45.0, 0.05
"""Of a case, and tick period [s]."""
GRAVITY, DENSITY = 9.81, 1025.0
"""Of earth [m/s^2] and sea water [kg/m^3], to draw by."""


def drawn(kind: str, number: int, folder: Path) -> Scenario:
    """Return a case as a scenario.

    Parameters
    ----------
    kind : of CASES; number : of the case
    folder : that its file may be written to
    """
    chance = np.random.default_rng(1000 * (list(CASES).index(kind) + 1) + number)
    on_deck = kind == "deck"
    length = chance.uniform(8.0, 60.0) if on_deck else math.exp(chance.uniform(math.log(15.0), math.log(3000.0)))
    height = chance.uniform(0.3, 3.0 if on_deck else 5.0)
    period = chance.uniform(max(4.0, 3.6 * math.sqrt(height)), 16.0)
    mass = math.exp(chance.uniform(math.log(1500.0), math.log(60e3)))
    volume = mass / DENSITY * chance.uniform(0.1, 0.7)
    weight = (mass - DENSITY * volume) * GRAVITY
    stiffness = max(mass * GRAVITY * math.exp(chance.uniform(math.log(60.0), math.log(500.0))), 3e6)
    per_metre = chance.uniform(0.2, 1.0) * min(1.5 * stiffness / 5e6, 0.5 * mass / length + 0.3)
    assumed = mass + (chance.uniform(0.8, 1.25) - 1.0) * weight / GRAVITY
    tip = length + 8.0 if on_deck else 5.0
    plant: dict[str, object] = {
        "segments": 10,
        "sensors": {name: {"fitted": False} for name in ("velocity", "imu", "usbl")},
    }
    if kind == "land":
        stretch = length * weight / stiffness
        slack = chance.uniform(0.0, 2.0) if number % 2 else -stretch * chance.uniform(0.0, 0.35)
        plant["seabed"] = {"depth": length - tip - slack}
    elif on_deck:
        plant["seabed"] = {"depth": length - chance.uniform(0.0, 1.0), "deck": True}
        plant["unit"] = {"box": {"length": 2.0, "breadth": 2.0, "height": max(volume / 3.0, 1.0)}}
    cable = {
        "axial_stiffness": stiffness,
        "mass_per_length": per_metre,
        "diameter": 1.3 * math.sqrt(4.0 * per_metre / math.pi / 5000.0),
    }
    system = {
        "length": length,
        "boom_tip_height": tip,
        "sea": {"significant_wave_height": height, "peak_period": period},
        "cable": cable,
        "unit": {"mass": mass, "volume": volume, "added_mass": [mass] * 3},
    }
    sections = {
        "/**": {"duration": DURATION, "transient": 30.0, "seed": number + 1, "system": system},
        "/**/wave_vessel": {"ramp": 5.0},
        "/**/cable_sim": plant,
        "/**/winch_controller": {"modes": {"settling_time": 12.0}, "unit": {"mass": assumed}},
    }
    path = folder / f"{kind}_{number}.yaml"
    path.write_text(yaml.safe_dump({name: {"ros__parameters": one} for name, one in sections.items()}))
    return load_scenario(str(path))


def row(kind: str, number: int, folder: Path) -> str:
    """Run a case and return it as a row of the table; arguments as of `drawn`."""
    loop = ClosedLoop(loop_parameters(drawn(kind, number, folder)))
    found = began = math.nan
    while loop.tick * TICK < min(DURATION, began + 1.0 if began > 0.0 else DURATION):
        outputs, _ = loop.step()
        if math.isnan(found) and any(alarm.code == "UNIT_NOT_SUSPENDED" for alarm in outputs.alarms):
            found = loop.tick * TICK
        if math.isnan(began) and outputs.mode == "compensating":
            began = loop.tick * TICK
    return f"| {kind} | {number} | {found:.1f} | {began:.1f} |"


def main() -> None:
    """Print the table."""
    print(commit_line(), "| load | case | does not hang after s | compensates after s |\n|---|---|---|---|", sep="\n")  # noqa: T201
    with tempfile.TemporaryDirectory() as folder:
        for kind, count in CASES.items():
            for number in range(count):
                print(row(kind, number, Path(folder)), flush=True)  # noqa: T201


if __name__ == "__main__":
    main()
