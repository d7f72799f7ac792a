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
