"""A bag in the place of a node: the recorded sea through the same scenario gives the same run, byte for byte."""

from tests.loop_runs import CALM_DURATION, recorded_messages, run_scenario


def test_the_recorded_sea_through_the_same_scenario_gives_the_same_run(calm_bag, tmp_path):
    options = ["--from-bag", f"wave_vessel={calm_bag}"]
    again = run_scenario(tmp_path / "again", duration=CALM_DURATION, options=options)
    assert recorded_messages(again) == recorded_messages(calm_bag)


def test_the_recorded_sea_against_another_controller_is_the_same_sea_and_another_run(calm_bag, tmp_path):
    options = ["--from-bag", f"wave_vessel={calm_bag}", "--set", "winch_controller.law=off"]
    what_if = recorded_messages(run_scenario(tmp_path / "what_if", duration=CALM_DURATION, options=options))
    before = recorded_messages(calm_bag)
    for topic in ("/boom_tip", "/mru", "/unit_uncompensated"):
        assert [m for m in what_if if m[0] == topic] == [m for m in before if m[0] == topic]
    assert [m for m in what_if if m[0] == "/controller/state"] != [m for m in before if m[0] == "/controller/state"]
