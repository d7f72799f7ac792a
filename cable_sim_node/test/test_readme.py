"""The README says what the code does: its table holds every sensor, and its example runs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from cable_sim_node.sensors.instruments import SensorsParameters

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")


def test_every_sensor_stands_in_the_table_of_sensors() -> None:
    table = README.split("## Sensors")[1].split("```")[0]
    assert re.findall(r"^\| `([a-z_]+)`", table, flags=re.MULTILINE) == list(SensorsParameters().by_name())


def test_example_runs(capsys: pytest.CaptureFixture[str]) -> None:
    example = re.search(r"```python\n(.*?)```", README, flags=re.DOTALL)
    assert example is not None
    exec(example.group(1).replace("print(", "result = ("), scope := {})
    tension, _ = scope["result"]
    assert tension == pytest.approx(36516.6, abs=1.0)
