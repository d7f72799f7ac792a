"""One line for a user: the words of whoever foresaw an error, and for all others its type, file and line."""

import inspect

from heave_bags.errors import StorageError
from heave_node.errors import NodeError, one_line
from heave_node.tick.clock_rule import parse_clock
from heave_node.tick.gate import Inbox


class NodeOfTheirs:
    """A node whose class stands in this file."""


def caught(work):
    try:
        work()
    except Exception as error:
        return error
    raise AssertionError("no error")


def fail_in_the_library():
    int("seven")  # here


def refuse():
    raise NodeError("the load cell\n  is not connected")


def test_words_for_the_user_stand_alone():
    assert one_line(caught(refuse), NodeOfTheirs) == "the load cell is not connected"


def test_words_of_any_exception_of_the_suite_stand_alone():
    def full_disk():
        raise StorageError("bag_0.mcap: the disk is full")

    assert one_line(caught(full_disk), NodeOfTheirs) == "bag_0.mcap: the disk is full"


def test_an_error_that_nobody_worded_is_shown_with_type_file_and_line():
    line = fail_in_the_library.__code__.co_firstlineno + 1
    expected = f"ValueError: invalid literal for int() with base 10: 'seven' (test_errors.py, line {line})"
    assert one_line(caught(fail_in_the_library), NodeOfTheirs) == expected


def test_the_place_is_in_the_users_code_also_where_a_library_raised_the_error():
    def ask_the_library():
        import json  # noqa: PLC0415

        json.loads("{")

    assert "(test_errors.py, line " in one_line(caught(ask_the_library), NodeOfTheirs)


def test_the_place_is_in_a_law_of_the_users_own_that_the_suite_called(tmp_path):
    law = tmp_path / "my_law.py"
    law.write_text("def command(state):\n    return state.y\n")
    theirs, suites = {}, {"__package__": "heave_node"}
    exec(compile(law.read_text(), str(law), "exec"), theirs)
    exec(compile("def tick(law):\n    law(0)\n", inspect.getfile(Inbox), "exec"), suites)
    line = one_line(caught(lambda: suites["tick"](theirs["command"])), Inbox)
    assert line == "AttributeError: 'int' object has no attribute 'y' (my_law.py, line 2)"


def test_the_suite_words_its_own_value_errors():
    refused = caught(lambda: Inbox("/mru", bytes).take("seven"))
    assert isinstance(refused, TypeError)
    assert one_line(refused, NodeOfTheirs).startswith("TypeError: ")
    worded = caught(lambda: parse_clock("winch=tomorrow"))
    assert isinstance(worded, ValueError)
    assert one_line(worded, NodeOfTheirs) == str(worded)
