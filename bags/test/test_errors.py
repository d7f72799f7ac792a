"""What went wrong is said in one line, whatever a bag's names hold."""

from heave_bags.errors import BagError, StorageError, one_line


def test_a_message_stays_on_its_line_and_sends_nothing_to_the_terminal():
    assert str(BagError("/a\nb: \x1b[2Jgone")) == "/a\\nb: \\x1b[2Jgone"
    assert str(StorageError("plain")) == "plain"


def test_letters_of_all_languages_stay():
    assert one_line("Wasserlinie ü, 波") == "Wasserlinie ü, 波"
