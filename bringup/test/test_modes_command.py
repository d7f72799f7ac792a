"""`heave modes`: prints natural periods, draws mode shapes and the resonance map."""

import json

import pytest
from heave_bringup.cli import main


def test_the_modes_of_the_deep_scenario_have_a_table_a_picture_and_numbers(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["modes", "b3_deep_900", "--json", "result.json"]) == 0
    printed = capsys.readouterr().out
    assert str(tmp_path / "b3_deep_900_modes.svg") in printed
    assert "<svg" in (tmp_path / "b3_deep_900_modes.svg").read_text(encoding="utf-8")
    values = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
    assert values["heave_periods_s"][0] == pytest.approx(16.9, abs=0.1)  # thesis 6.2.6
    assert values["sea_period_s"] == 10.0
    assert values["critical_length_m"] == pytest.approx(320.0, abs=5.0)


def test_length_and_period_may_be_given(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = ["--set", "system.length=450", "--longest", "1200", "--period", "12", "--json", "-"]
    assert main(["modes", "b3_deep_900", *options, "--picture", "modes.png"]) == 0
    values = json.loads(capsys.readouterr().out)
    assert (values["length_m"], values["sea_period_s"]) == (450.0, 12.0)
    assert values["resonance"][-1]["length_m"] == 1200.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--period", "nan"], "heave: --period nan: must be a number above 0"),
        (["--longest", "-3"], "heave: --longest: length = -3.0 is not allowed"),
        (["--picture", "x.doc"], "heave: --picture x.doc: must end in .png or .svg"),
    ],
)
def test_a_wrong_option_is_refused_in_one_line(arguments, words, capsys):
    assert main(["modes", "b3_deep_900", *arguments]) == 2
    said = capsys.readouterr().err
    assert said.startswith(words)
    assert said.count("\n") == 1
