"""What the `heave` command says of a wrong command line."""

import pytest
from heave_bringup.cli import main


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run"], "heave run: the following arguments are required: SCENARIO"),
        (["run", "b2_calm_300", "--duratoin", "3"], "heave: unrecognized arguments: --duratoin 3"),
        (["run", "b2_calm_300", "--seed", "one"], "heave run: argument --seed: invalid int value: 'one'"),
        (["repair", "bag"], "heave repair: one of the arguments --output --reindex is required"),
        (["sail"], "heave: argument COMMAND: invalid choice: 'sail'"),
        (["run", "no_such_scenario"], "heave: no_such_scenario"),
        (["run", "b2_calm_300", "--set", "cable_sim.length=-1"], "heave: "),
        (["static", "b3_deep_900", "--picture", "x.doc"], "heave: --picture x.doc: must end in .png or .svg"),
        (["identify", "b3_deep_900", "--picture", "x.doc"], "heave: --picture x.doc: must end in .png or .svg or"),
        (["kpi", "no_bag", "--table", "x.foo"], "heave: --table x.foo: must end in .csv or .parquet"),
        (["kpi", "no_bag", "--table", "nodir/x.csv"], "heave: --table nodir/x.csv: there is no folder nodir"),
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


def test_a_file_that_the_system_refuses_is_one_line_and_status_1(capsys):
    assert main(["static", "b2_calm_300", "--picture", "/proc/x.svg"]) == 1
    assert capsys.readouterr().err == "heave: /proc/x.svg: No such file or directory\n"
