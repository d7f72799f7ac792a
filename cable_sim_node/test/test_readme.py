"""The README says what the code does: its tables hold every parameter with its default, and its example runs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from cable_sim_node.node_parameters import CableSimNodeParameters
from cable_sim_node.winch.parameters import WinchParameters
from heave_node.parameters import ParameterInfo, describe

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
INFOS = [info for kind in (WinchParameters, CableSimNodeParameters) for info in describe(kind)]


@pytest.mark.parametrize("info", [i for i in INFOS if "sensors." not in i.name or ".faults." not in i.name], ids=str)
def test_parameter_stands_in_a_table_with_its_default(info: ParameterInfo) -> None:
    rows = re.findall(rf"^\| `{re.escape(info.name)}` \| (.*?) \| (.*?) \| (.*?) \|$", README, flags=re.MULTILINE)
    defaults = [default for default, unit, text in rows if (unit, text) == (info.unit, info.description)]
    assert defaults, f"wanted: | `{info.name}` | {info.default} | {info.unit} | {info.description} |"
    if info.type is float and not info.is_array:
        assert any(float(default) == pytest.approx(info.default, rel=1e-5) for default in defaults)


def test_example_runs(capsys: pytest.CaptureFixture[str]) -> None:
    example = re.search(r"```python\n(.*?)```", README, flags=re.DOTALL)
    assert example is not None
    exec(example.group(1).replace("print(", "result = ("), scope := {})
    tension, _ = scope["result"]
    assert tension == pytest.approx(36516.6, abs=1.0)


def test_every_picture_is_there() -> None:
    pictures = re.findall(r"\]\((pictures/.*?)\)", README)
    assert len(pictures) == 5
    assert all((Path(__file__).parents[1] / picture).is_file() for picture in pictures)
