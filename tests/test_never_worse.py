"""Never worse than with the winch locked, and no healthy part blamed: whole loops, a row each of `never_worse.yaml`.

Random cases are drawn by `heave study few`, `stacked`, `seas` and `lifts`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from heave_bags.analyse import kpi_set
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.run.loop_signals import run_signals
from heave_bringup.scenarios import Scenario, load_scenario

from tests.loops import TROUBLE, begin_of, blamed, changes, fault, heave_of, left, loop_of, settings_text, worst_minute

ROWS = yaml.safe_load(Path(__file__).with_name("never_worse.yaml").read_text(encoding="utf-8"))
INPUTS = {"name", "scenario", "law", "seed", "duration", "set", "fault", "ask", "long", "open", "from"}
NOMINAL = {"winch.time_constant": 0.15, "winch.command_delay": 0.2, "winch.speed_gain": 1.0}
"""What the scenarios assume of their winch: servo and delay are found together."""
NEAR, SHARE = 0.01, 0.03
"""How far a belief may be from nominal [s], [-], and from what it should be, as a share."""


def scenario_of(row: Mapping[str, Any]) -> Scenario:
    """Return the scenario of a row."""
    settings = {f"{node}.{name}": value for node, own in row.get("set", {}).items() for name, value in own.items()}
    settings |= {f"all.{name}": row[name] for name in ("seed", "duration") if name in row}
    settings |= {"winch_controller.law": row["law"]} if "law" in row else {}
    settings |= fault(*row["fault"]) if "fault" in row else {}
    return load_scenario(row["scenario"], settings=settings_text(settings))


class Lift:
    """A row that has been run, with a check for each of its words."""

    def __init__(self, row: Mapping[str, Any]) -> None:
        self.row, self.scenario = row, scenario_of(row)
        self.parameters = loop_parameters(self.scenario)
        self.loop = ClosedLoop(self.parameters)
        asked = list(row.get("ask", ()))

        def ask(tick: int, _: object) -> None:
            while asked and tick >= round(asked[0][0] / self.parameters.tick_period):
                self.loop.controller.set_mode(asked.pop(0)[1])

        self.record: LoopRecord = self.loop.run(ask)
        self.began = min(begin_of(self.record), 60.0)
        self.start = max(self.began, row["fault"][2] if "fault" in row else 0.0)
        self.codes = [alarm.name for _, alarm in self.record.alarms]

    def judge(self) -> None:
        """Check all that the row asks for."""
        for word in set(self.row) - INPUTS:
            getattr(self, f"check_{word}")(self.row[word])

    def check_begins(self, time: float) -> None:
        assert begin_of(self.record) < time, self.codes

    def check_keeps(self, time: float) -> None:
        assert set(np.array(self.record.modes)[self.record.column("time") >= time]) == {"compensating"}

    def check_ends(self, mode: str) -> None:
        assert self.record.modes[-1] == mode

    def check_modes(self, modes: list[str]) -> None:
        assert [mode for mode, _ in changes(self.record)] == modes

    def check_worst(self, largest: float) -> None:
        assert worst_minute(self.record, self.row.get("from", self.start + TROUBLE)) < largest

    def check_left(self, given: list[float]) -> None:
        assert left(self.record, given[0]) < given[1]

    def check_moves(self, given: list[float]) -> None:
        unit = heave_of(self.record)[round(given[0] / self.parameters.tick_period) :]
        assert np.max(np.abs(unit - unit[0])) < given[1]

    def check_blames(self, parts: list[str]) -> None:
        assert blamed(self.record) == set(parts), self.codes

    def check_alarms(self, codes: list[str]) -> None:
        assert self.codes == codes

    def check_codes(self, codes: Mapping[str, Any]) -> None:
        for code, wanted in codes.items():
            came = [(time, alarm.values) for time, alarm in self.record.alarms if alarm.name == code]
            assert came, code
            if not isinstance(wanted, dict):
                assert came[0][0] < self.start + wanted, code
                continue
            for name, value in wanted.items():
                if isinstance(value, list):
                    words, number, share = value
                    found = re.findall(rf"{words} (-?[\d.]+)", str(came[0][1][name]))
                    assert [float(one) for one in found] == [pytest.approx(number, rel=share)], code
                else:
                    assert came[0][1][name] == pytest.approx(value, rel=0.005), code

    def check_without(self, codes: list[str]) -> None:
        assert not set(codes) & set(self.codes)

    def check_assumed(self, wanted: Mapping[str, Any]) -> None:
        for names, value, share in self._wanted(wanted):
            found = [one for known, one in self._assumed.items() if known in names.removesuffix("?").split("|")]
            assert found or names.endswith("?"), names
            assert found == pytest.approx([value] * len(found), rel=share), names

    def check_nothing_else(self, _: bool) -> None:
        named = tuple(one for names in self.row["assumed"] for one in names.removesuffix("?").split("|"))
        others = {name: value for name, value in self._assumed.items() if not name.startswith((*named, "sea."))}
        assert others == {name: pytest.approx(NOMINAL.get(name), abs=NEAR) for name in others}

    def check_wanted(self, _: bool) -> None:
        run = self.scenario.run
        figures = kpi_set.evaluate(run_signals(self.record, self.parameters), run.transient, run.duration)
        # the signals of a loop have no reasons of its modes
        figures |= {"compensation_losses": float(self.codes.count("COMPENSATION_LOST"))}
        assert [one.kpi for one in self.scenario.wanted if not one.is_met(figures[one.kpi])] == []

    @property
    def _assumed(self) -> dict[str, float]:
        return {name: belief.value for name, belief in self.loop.controller.beliefs.values.items()}

    def _wanted(self, wanted: Mapping[str, Any]) -> Iterator[tuple[str, float, float]]:
        for name, value in wanted.items():
            yield (name, *value) if isinstance(value, list) else (name, value, SHARE)


def marks_of(row: Mapping[str, Any]) -> list[pytest.MarkDecorator]:
    """Return the marks of a row: it is left to `make validate`, or it is open and not kept today.

    An open row is a counter-example that is written down. It must be run to its end and miss a bound: an error of
    another kind fails, and so does a row that is kept again, until its `open` is removed.
    """
    marks = [pytest.mark.long] if row.get("long") else [pytest.mark.slow]
    return [*marks, pytest.mark.xfail(reason=row["open"], strict=True)] if "open" in row else marks


@pytest.mark.parametrize("row", [pytest.param(row, id=row["name"], marks=marks_of(row)) for row in ROWS])
def test_a_lift_keeps_the_promise(row: Mapping[str, Any]) -> None:
    """What each row asks for is in its own words."""
    Lift(row).judge()


@pytest.mark.long
@pytest.mark.parametrize(
    ("scenario", "height", "period"),
    [
        ("b10_real_mru_swell", 2.0, 6.0),  # a wind sea shorter than assumed beside a swell as assumed lost the loop
        ("b3_deep_900", 3.0, 8.0),
        ("b2_calm_300", 3.0, 10.0),
    ],
)
def test_a_sea_other_than_assumed_is_met_nearly_as_well_as_one_that_is_known(scenario, height, period):
    """1.3 times the motion that a controller leaves which knows the sea."""
    sigmas = []
    for owner in ("wave_vessel", "system.sea"):
        sea = {f"{owner}.significant_wave_height": height, f"{owner}.peak_period": period}
        settings = settings_text({**sea, "all.duration": 400.0, "all.transient": 130.0, "all.seed": 1})
        record = ClosedLoop(loop_parameters(load_scenario(scenario, settings=settings))).run()
        assert left(record, 130.0) <= 1.05
        sigmas.append(record.unit_sigma(130.0))
    assert sigmas[0] <= max(1.3 * sigmas[1], sigmas[1] + 0.001)


@pytest.mark.long
def test_the_tension_held_on_a_landed_load_swings_by_the_friction_of_the_sheaves():
    """Held is what the load cell reads, so the cable's tension may be off by e^f either way (Eytelwein), beside the
    4.6 kN by which it swings without friction.
    """
    friction = 0.05
    settings = {"cable_sim.rope_path.friction": friction, "cable_sim.rope_path.stiffness": 2e6}
    record = loop_of("b13_landing_soft", settings).run()
    held = record.column("top_tension", after=float(record.column("time")[-1]) - 30.0)
    loop = 2.0 * float(held.mean()) * np.sinh(friction)
    assert 0.5 * loop < np.ptp(held) - 4.6e3 < loop
