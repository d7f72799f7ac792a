"""An extra that is not installed: what the suite does without it, and what it says where it is asked for."""

import subprocess
import sys

import cable_sim_node.winch.parameters  # noqa: F401 - made with the drives that are installed, before any test hides them
import pytest
from cable_sim_node.winch import installed_drives as registry
from domain_coordinator import domain_id
from heave_bringup.cli import main
from heave_bringup.errors import CommandError
from heave_bringup.run.records import read_records
from heave_node import extras

from tests.loop_runs import environment

GROUP = "heave.commands"


@pytest.fixture
def alone(monkeypatch):
    """Let no extra be installed."""
    monkeypatch.setattr(extras, "entry_points", lambda group: [])
    caches = (extras.extra_parts.cache_clear, registry.installed_drives.cache_clear)
    for clear in caches:
        clear()
    yield
    for clear in caches:
        clear()


@pytest.mark.parametrize("name", extras.PARTS[GROUP])
def test_a_command_of_a_missing_extra_names_it_in_one_line(alone, name, capsys):
    assert main([name, "whatever"]) != 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"heave: heave {name} needs heave[{extras.extra_of(GROUP, name)}]; ")


@pytest.mark.parametrize(
    ("words", "needs"),
    [
        (["kpi", "BAG", "--baseline"], "--baseline needs heave[studies]"),
        (["run", "b2_calm_300", "--set", "virtual_winch.drive=electric"], "drive = electric needs heave[drives]"),
        (["run", "b2_calm_300", "--replace", "virtual_winch=fmu:x.fmu"], "virtual_winch=fmu:x.fmu needs heave[fmu]"),
    ],
)
def test_an_option_of_a_missing_extra_names_it_in_one_line(alone, words, needs, calm_bag, capsys):
    assert main([str(calm_bag) if word == "BAG" else word for word in words]) != 0
    assert needs in capsys.readouterr().err.splitlines()[-1]


def test_a_table_without_pandas_is_refused_before_the_bag_is_read(monkeypatch, tmp_path, capsys):
    monkeypatch.setitem(sys.modules, "pandas", None)
    assert main(["export", str(tmp_path / "no_such_bag"), "--table", str(tmp_path / "table.csv")]) != 0
    assert capsys.readouterr().err.startswith("heave: heave export needs heave[frames] (no module pandas); ")


def test_without_studies_a_bag_is_judged_and_their_rows_are_left_out(alone, calm_bag, capsys):
    (record,) = read_records([calm_bag], baseline=None)
    assert record.kpis()["unit_sigma_m"] > 0.0
    assert record.signals.baseline is None
    assert main(["kpi", str(calm_bag)]) == 0
    assert main(["report", str(calm_bag), "--output", str(calm_bag.parent / "alone.html")]) == 0
    told = capsys.readouterr()
    assert "kappa" not in told.out
    assert "industrial" not in told.out
    with pytest.raises(CommandError):
        read_records([calm_bag], baseline=True)


ALONE = """
import sys
from heave_node import extras

class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("heave_devices", "heave_drives", "heave_fmu", "heave_panel", "heave_statics",
                                      "heave_studies"):
            raise ModuleNotFoundError(name, name=name)

sys.meta_path.insert(0, Hidden())
extras.entry_points = lambda group: []
from heave_bringup.cli import main
sys.exit(main(sys.argv[1:]))
"""
"""`heave` where no extra can be imported."""


@pytest.mark.slow
def test_the_seven_packages_alone_run_record_judge_and_report(tmp_path):
    words = ["run", "b2_calm_300", "--duration", "12", "--set", "all.transient=4", "--composed", "--bag", str(tmp_path)]
    with domain_id() as domain:
        run = subprocess.run(
            [sys.executable, "-c", ALONE, *words],
            env=environment(domain),
            capture_output=True,
            text=True,
            timeout=240,
            check=False,
        )
    assert run.returncode == 0, run.stderr
    assert "no verdict: only 8 s after the transient" in run.stdout
    assert (tmp_path / "bag" / "metadata.yaml").is_file()
    assert (tmp_path / "report.html").is_file()
