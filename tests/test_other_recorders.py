"""One run, three recorders: the suite's own, `heave record` beside it by the host's clock, and one of others."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from domain_coordinator import domain_id
from heave_bags.analyse import kpi_set
from heave_bags.mcap.reader import Bag
from heave_node.cdr.unpacker import header_stamp

from tests.loop_runs import HAS_RUN, command, environment, heave, recorded_messages, run_scenario, wait_until

sys.path.insert(0, str(Path(__file__).parents[1] / "bags" / "test"))

from foreign_bags import by_host_clock, write_foreign

DURATION = 12.0
OPTIONS = ("--duration", str(DURATION), "--set", "all.transient=4", "--no-report")


@pytest.fixture(scope="module")
def bags(tmp_path_factory) -> dict[str, Path]:
    """Return the bags of one run by who recorded them, and the scenario of the run."""
    folder = tmp_path_factory.mktemp("recorders")
    with domain_id() as domain:
        recorder = subprocess.Popen(command("record", str(folder / "live")), env=environment(domain))
        try:
            wait_until((folder / "live" / "metadata.yaml").exists, 60.0)
            run = command("run", "b2_calm_300", *OPTIONS, "--bag", str(folder / "run"))
            done = subprocess.run(run, env=environment(domain), check=False, timeout=300.0, stdout=subprocess.DEVNULL)
            assert done.returncode in HAS_RUN
        finally:
            recorder.send_signal(signal.SIGINT)
            recorder.wait(60.0)
    suite = folder / "run" / "bag"
    others = write_foreign(suite, folder / "others", by_host_clock)
    return {"suite": suite, "live": folder / "live", "others": others, "scenario": folder / "run" / "scenario.yaml"}


@pytest.mark.slow
@pytest.mark.parametrize("recorder", ["others", pytest.param("live", marks=pytest.mark.long)])
def test_the_figures_of_a_run_are_the_same_to_every_digit_whoever_recorded_it(bags, recorder):
    own = json.loads(heave("kpi", str(bags["suite"]), "--json", "-").stdout)
    result = heave("kpi", str(bags[recorder]), "--scenario", str(bags["scenario"]), "--json", "-")
    assert result.returncode == 0, result.stderr
    found = json.loads(result.stdout)
    of_run = [d.key for d in kpi_set.KPI_DEFINITIONS if d.group != kpi_set.TIMING]
    assert {key: found[key] for key in of_run} == {key: own[key] for key in of_run}
    assert (found["window_start_s"], found["window_end_s"]) == (own["window_start_s"], own["window_end_s"])
    assert found["unit_sigma_m"] > 0.0


@pytest.mark.long
def test_what_another_recorder_says_of_itself_is_no_part_of_a_run_in_lockstep(bags):
    """`heave record` reports its health each second, by the host's clock."""
    stamps = [header_stamp(message.data) for message in Bag(bags["suite"]).messages(topics=["/diagnostics"])]
    assert stamps
    assert max(stamps) <= (DURATION + 1.0) * 1e9


@pytest.mark.slow
@pytest.mark.long
def test_the_sea_that_heave_record_has_recorded_leads_to_the_same_run(bags, tmp_path):
    options = ["--replace", f"wave_vessel=bag:{bags['live']}", "--set", "all.transient=4"]
    again = run_scenario(tmp_path / "again", duration=DURATION, options=options)
    assert of_the_run(again) == of_the_run(bags["suite"])


def of_the_run(bag: Path) -> list[tuple[str, int, int]]:
    """Return the messages of a bag without /diagnostics, where the other recorder speaks as well."""
    return [message for message in recorded_messages(bag) if message[0] != "/diagnostics"]
