"""The candidates that the shell gets for the next word, as argcomplete asks for them."""

import os
import subprocess
import sys

import pytest


def completions(line):
    ask = {
        **os.environ,
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_IFS": "\n",
        "_ARGCOMPLETE_STDOUT_FILENAME": "/dev/stdout",
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
    }
    done = subprocess.run(
        [sys.executable, "-m", "heave_bringup.cli"], env=ask, capture_output=True, text=True, timeout=60, check=False
    )
    return [word.strip() for word in done.stdout.split("\n") if word]


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ("heave operat", "operate"),
        ("heave stu", "study"),
        ("heave operate emer", "emergency-stop"),
        ("heave run b3_", "b3_deep_900"),
        ("heave run b3_deep_900 --qui", "--quiet"),
        ("heave kpi --no-b", "--no-baseline"),
        ("heave params winch_c", "winch_controller"),
        ("heave params recorder snapshot_d", "snapshot_duration"),
        ("heave operate fault inject mru fre", "freeze"),
    ],
)
def test_the_shell_completes(line, word):
    assert completions(line) == [word]
