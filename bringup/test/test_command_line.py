"""What the `heave` command says of a wrong command line."""

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from heave_bags.mcap.bag_writer import BagWriter
from heave_bringup.cli import main


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run"], "heave run: the following arguments are required: SCENARIO"),
        (
            ["run", "b2_calm_300", "--duratoin", "3"],
            "heave run: unrecognized arguments: --duratoin 3; did you mean --duration?",
        ),
        (
            ["design", "b2_calm_300", "--length", "5"],
            "heave design: unrecognized arguments: --length 5; see heave design --help",
        ),
        (["run", "b2_calm_300", "--publish"], "heave: --publish: goes with --composed"),
        (
            ["run", "b2_calm_300", "--composed", "--replace", "wave_vessel=lockstep"],
            "heave: --composed: wave_vessel is replaced, so the nodes need a process each; omit --composed",
        ),
        (
            ["run", "b2_calm_300", "--replace", "virtual_winch=lockstep", "--replace", "virtual_winch=fmu:drive.fmu"],
            "heave: --replace virtual_winch=fmu:drive.fmu: virtual_winch is replaced already",
        ),
        (
            ["fmu", "b2_calm_300", "--part", "wnich"],
            "heave fmu: argument --part: invalid choice: 'wnich'; did you mean",
        ),
        (
            ["fmu", "b2_calm_300", "--language", "c", "--part", "winch"],
            "heave: --language c: only the controller can be in C: --part controller",
        ),
        (["fmu", "b2_calm_300", "--folder", __file__], f"heave: --folder {__file__}: File exists"),
        (["run", "b2_calm_300", "--seed", "one"], "heave run: argument --seed: must be a whole number: 'one'"),
        (["repair", "bag"], "heave repair: one of the arguments --output --reindex is required"),
        (["sail"], "heave: argument COMMAND: invalid choice: 'sail'"),
        (["rnu"], "heave: argument COMMAND: invalid choice: 'rnu'; did you mean run?"),
        (["adapt", "--show", "no_map"], "heave: --show no_map: is no shipped map"),
        (["adapt", "no_map"], "heave: no_map: there is no such file"),
        (["adapt", "--check", __file__], f"heave: {__file__}: "),
        (["study", "--show", "no_such"], "heave: no_such: no such study or file"),
        (["export", __file__, "--table", "x.csv"], f"heave: {__file__}: a text file, not an MCAP file; give "),
        (["run", "b2_calm_300", "--bag", str(Path(__file__).parent)], f"heave: {Path(__file__).parent}: is not empty"),
        (["run", "no_such_scenario"], "heave: no_such_scenario"),
        (
            ["run", "b2_calm_300", "--set", "cable_sim.length=-1"],
            "heave: --set cable_sim.length=-1: length = -1.0 is not allowed: it must be a number from 0.01 to 20000",
        ),
        (["run", "b2_calm_300", "--duration", "-5"], "heave: --duration -5.0: duration = -5.0 is not allowed: it must"),
        (["run", "b2_calm_300", "--set", "all.seed=x"], "heave: --set all.seed=x: seed = 'x' is not allowed: it must"),
        (["run", "b2_calm_300", "--replace", "cable_sim=external"], "heave: "),
        (["run", "b2_calm_300", "--replace", "mrv=external:own"], "heave: --replace mrv=external:own: no such node or"),
        (["run", "b2_calm_300", "--replace", "mru=external:ship"], "heave: --replace mru=external:ship: ext"),
        (
            ["run", "b2_calm_300", "--replace", "winch_controller=none"],
            "heave: --replace winch_controller=none: NODE must",
        ),
        (["run", "b2_calm_300", "--replace", "mru=lockstep"], "heave: --replace mru=lockstep: no such node: mru"),
        (
            ["run", "b2_calm_300", "--replace", "recorder=lockstep"],
            "heave: --replace recorder=lockstep: NODE must be one",
        ),
        (
            ["run", "b2_calm_300", "--replace", "wave_vessel=bag"],
            "heave: --replace wave_vessel=bag: must be NODE=bag:DIR",
        ),
        (["run", "b2_calm_300", "--replace", "wave_vessel=bag:no"], "heave: --replace wave_vessel=bag:no: no such bag"),
        (["run", "b2_calm_300", "--replace", "wave_vessel"], "heave: --replace wave_vessel: must be NODE=WHAT"),
        (
            ["run", "b2_calm_300", "--replace", "cable_sim=fmu:x.fmu"],
            "heave: --replace cable_sim=fmu:x.fmu: NODE must be",
        ),
        (["check", "--replace", "wave_vessel=lockstep"], "heave: --replace wave_vessel=lockstep: must be NODE=WHAT"),
        (
            ["study", "sea_trial", "--ask", "replace=mrv=external"],
            "heave: ask: replace mrv=external: no such node or sensor",
        ),
        (["operate", "sail"], "heave operate: argument VERB: invalid choice: 'sail'"),
        (["operate", "factor", "2"], "heave operate factor: argument F: 2: must be a number from 0 to 1"),
        (["operate", "depth", "nan"], "heave operate depth: argument D: nan: must be a number from "),
        (["run", "b2_calm_300", "--seed", "1.5"], "heave run: argument --seed: must be a whole number: '1.5'"),
        (
            ["run", "b2_calm_300", "--duration", "5min"],
            "heave run: argument --duration: must be a number of seconds: '5min'",
        ),
        (["operate", "depth", "deep"], "heave operate depth: argument D: deep: must be a number from "),
        (["operate", "step", "0"], "heave operate step: argument N: 0: must be a whole number of at least 1"),
        (["operate", "fault", "inject", "mru", "clear"], "heave operate fault inject: argument kind: invalid choice"),
        (
            ["operate", "fault", "inject", "winch", "freeze"],
            "heave: winch: a fault of kind freeze is unknown; known: gap, delay, jitter, drive,",
        ),
        (["operate", "fault", "inject", "mru", "scale"], "heave: mru: the magnitude of kind scale must be a factor"),
        (["operate", "fault", "inject", "depth", "restart"], "heave: depth: a fault of kind restart is unknown"),
        (["panel", "--port", "0"], "heave panel: argument --port: 0: must be a whole number from 1 to 65535"),
        (["view", "--port", "high"], "heave view: argument --port: high: must be a whole number from 1 to 65535"),
        (["operate", "--json", "-"], "heave operate: the following arguments are required: VERB"),
        (["study", "model_error", "--processes", "0"], "heave: --processes 0: must be at least 1"),
        (["static", "b3_deep_900", "--picture", "x.doc"], "heave: --picture x.doc: must end in .png or .svg"),
        (["identify", "b3_deep_900", "--picture", "x.doc"], "heave: --picture x.doc: must end in .png or .svg or"),
        (["kpi", "no_bag", "--table", "x.foo"], "heave: --table x.foo: must end in .csv or .parquet or .xlsx"),
        (["kpi", "no_bag", "--table", "nodir/x.csv"], "heave: --table nodir/x.csv: there is no folder nodir"),
        (["report", "no_bag", "--output", "x.doc"], "heave: --output x.doc: must end in .html or .htm"),
        (["kpi", "no_bag", "--window", "-3"], "heave: --window -3: must be a number above 0 [s]"),
    ],
)
def test_a_wrong_command_line_is_one_line_and_status_2(arguments, words, capsys):
    try:
        status = main(arguments)
    except SystemExit as exit_:
        status = exit_.code
    said = capsys.readouterr().err
    assert status == 2
    assert said.startswith(words)
    assert said.count("\n") == 1


def test_a_kind_of_fault_is_answered_with_those_of_its_device(capsys):
    assert main(["run", "b2_calm_300", "--set", "wave_vessel.mru.faults.kind=[frezze]"]) == 2
    assert (
        "one of freeze, gap, spike, jump, scale, nan, rate, delay, jitter, restart, clear\n" in capsys.readouterr().err
    )


def test_the_version_is_that_of_the_project_with_its_commit_where_it_is_known(capsys):
    with pytest.raises(SystemExit) as exit_:
        main(["--version"])
    assert exit_.value.code == 0
    version = ElementTree.parse(Path(__file__).parents[1] / "package.xml").findtext("version")
    assert re.fullmatch(rf"heave {re.escape(version)}( \([0-9a-f]{{40}}(\+changes)?\))?\n", capsys.readouterr().out)


def test_a_file_that_the_system_refuses_is_one_line_and_status_1(tmp_path, capsys):
    (tmp_path / "full.svg").symlink_to("/dev/full")
    assert main(["static", "b2_calm_300", "--picture", str(tmp_path / "full.svg")]) == 1
    # what is compiled once after installation is reported before
    assert (
        capsys.readouterr()
        .err.splitlines()[-1]
        .endswith(": No space left on device; free space there or write elsewhere")
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["static", "b2_calm_300", "--picture", "/proc/x.svg"], "--picture /proc/x.svg: cannot be written: "),
        (["static", "b2_calm_300", "--json", "/proc/x.json"], "--json /proc/x.json: cannot be written: "),
        (["static", "b2_calm_300", "--json", "/proc"], "--json /proc: cannot be written: Is a directory"),
        (["static", "b2_calm_300", "--json", "no/x.json"], "--json no/x.json: there is no folder no"),
    ],
)
def test_an_output_that_cannot_be_written_is_refused_before_the_work(arguments, words, capsys):
    assert main(arguments) == 2
    assert capsys.readouterr().err.splitlines()[-1].startswith(f"heave: {words}")


def test_a_wrong_value_is_told_with_where_it_stands(tmp_path, capsys):
    scenario = tmp_path / "own.yaml"
    scenario.write_text("wave_vessel: {ros__parameters: {peak_period: abc}}\n")
    assert main(["static", str(scenario), "--set", "cable_sim.length=200"]) == 2
    assert capsys.readouterr().err.startswith(f"heave: {scenario}: /wave_vessel: peak_period = 'abc' is not allowed")
    scenario.write_text("wave_vessel: {ros__parameters: {peak_period: 8.0}}\n")
    assert main(["static", str(scenario), "--set", "wave_vessel.peak_period=abc"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("heave: --set wave_vessel.peak_period=abc: peak_period = 'abc' is not allowed: it must be")


def test_a_wrong_value_of_a_study_is_told_of_its_file(tmp_path, capsys):
    study = tmp_path / "own_study.yaml"
    study.write_text("scenario: b2_calm_300\nset: {wave_vessel.peak_period: abc}\n")
    assert main(["study", str(study)]) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert said.startswith(f"heave: {study}: wave_vessel: peak_period = 'abc' is not allowed")
    study.write_text("scenario: b2_calm_300\n")
    assert main(["study", str(study), "--duration", "5"]) == 2
    assert "heave: --duration 5: duration = 5 s leaves nothing after the transient" in capsys.readouterr().err


def test_the_folder_of_a_run_is_repaired_though_its_bag_lost_the_index(tmp_path):
    writer = BagWriter(tmp_path / "run" / "bag")
    writer.add_topic("/chatter", "std_msgs/msg/String")
    writer.write("/chatter", 1, b"\x00\x01\x00\x00\x02\x00\x00\x00a\x00")
    writer.close()
    (tmp_path / "run" / "bag" / "metadata.yaml").unlink()
    assert main(["repair", str(tmp_path / "run"), "--output", str(tmp_path / "saved")]) == 0
    assert main(["repair", str(tmp_path / "run"), "--reindex"]) == 0
    assert (tmp_path / "saved" / "metadata.yaml").is_file()
    assert (tmp_path / "run" / "bag" / "metadata.yaml").is_file()


@pytest.mark.parametrize("command", [["replay"], ["import", "--topic", "/heave", "--output", "sea.csv"], ["kpi"]])
def test_a_bag_that_does_not_exist_is_told_as_such(command, tmp_path, capsys):
    assert main([*command, str(tmp_path / "nothing")]) == 2
    assert capsys.readouterr().err.endswith("nothing: no such bag: no file or folder has this name\n")


def test_a_text_is_no_map(tmp_path, capsys):
    text = tmp_path / "text.txt"
    text.write_text("hello")
    assert main(["adapt", "--check", str(text)]) == 2
    assert "text.txt: is no map" in capsys.readouterr().err
