"""A bag in the place of a node: the recorded sea through the same scenario gives the same run, byte for byte."""

from tests.loop_runs import recorded_messages, run_scenario

DURATION = 10.0


def test_the_recorded_sea_through_the_same_scenario_gives_the_same_run(tmp_path):
    first = run_scenario(tmp_path / "first", duration=DURATION)
    again = run_scenario(tmp_path / "again", duration=DURATION, options=["--from-bag", f"wave_vessel={first}"])
    assert recorded_messages(again) == recorded_messages(first)


def test_the_recorded_sea_against_another_controller_is_the_same_sea_and_another_run(tmp_path):
    first = run_scenario(tmp_path / "first", duration=DURATION)
    options = ["--from-bag", f"wave_vessel={first}", "--set", "winch_controller.law=off"]
    what_if = recorded_messages(run_scenario(tmp_path / "what_if", duration=DURATION, options=options))
    before = recorded_messages(first)
    for topic in ("/boom_tip", "/mru", "/unit_uncompensated"):
        assert [m for m in what_if if m[0] == topic] == [m for m in before if m[0] == topic]
    assert [m for m in what_if if m[0] == "/controller/state"] != [m for m in before if m[0] == "/controller/state"]
