"""The operator's page in a real browser, at a run under way."""

import subprocess
import sys
import time
from pathlib import Path

import pytest
from domain_coordinator import domain_id

from tests.browser import NEEDED, Browser
from tests.loop_runs import command, environment, wait_until

PRESENT = "document.getElementById('lost') && document.getElementById('lost').style.display === 'none'"


WINCH = Path(__file__).parents[3] / "examples" / "winch.py"


@pytest.fixture
def panel(tmp_path):
    """Begin a run and a panel for it; return the run's process, the panel's, and its address."""
    with domain_id() as domain:
        settings = ["--set", "recorder.snapshot_duration=20", "--set", "winch_controller.modes.start=standby"]
        # lockstep: a machine under load is slow, but no message comes late
        general = ["--pacing", "lockstep", "--duration", "20000", "--no-report", "--bag", str(tmp_path / "run")]
        log = (tmp_path / "run.log").open("w")
        run = subprocess.Popen(
            command("run", "b2_calm_300", *general, *settings), env=environment(domain), stdout=log, stderr=log
        )
        served = None
        try:
            wait_until(lambda: " x real time" in (tmp_path / "run.log").read_text(), 180.0)
            served = subprocess.Popen(
                command("panel", "--port", "8079"), env=environment(domain), stdout=subprocess.PIPE, text=True
            )
            address = served.stdout.readline().split()[-1]
            yield run, served, address
        finally:
            for process in (served, run):
                if process is not None:
                    process.send_signal(2)
                    process.wait(60.0)


@pytest.mark.slow
@pytest.mark.long
@NEEDED
def test_two_viewers_operate_a_run_in_turns_and_a_dead_panel_is_seen_at_once_and_stops_nothing(panel, tmp_path):
    run, served, address = panel
    with Browser(tmp_path / "profile") as browser:
        first, second = browser.tab(), browser.tab()
        for tab, width in ((first, 1400), (second, 420)):
            tab.size(width, 900)
            tab.open(address)
            tab.wait_for("no viewer is in command; ")
            assert tab.get("document.documentElement.scrollWidth") <= width
        first.wait_for("2 watching")

        first.click("take command")
        first.wait_for("you are in command")
        second.wait_for("viewer 1 is in command")
        first.wait_for("estimate settled", 180.0)  # until then compensation is refused
        first.click("compensate")
        first.wait_for("Sure?")
        first.click("yes, do it")
        first.wait_for("mode compensating (law mpc, gain 1.00)", 120.0)
        first.click("move by")
        first.write("0.5")
        first.click("yes, do it")
        first.wait_for("arrived", 120.0)
        first.click("factor")
        first.write("many")
        first.click("do it")
        first.wait_for("'many' is no number")
        first.click("inject")
        first.wait_for("magnitude")
        first.click("yes, do it")  # mru, freeze
        first.wait_for("SENSOR_LOST, MRU", 60.0)
        first.wait_for("Action: Restart the sensor")
        first.click("clear faults")
        first.wait_for("(ended)", 60.0)
        while "SENSOR_LOST, MRU (ended)" in first.text:  # other alarms stand beside it on a busy machine
            first.click("acknowledge")
            time.sleep(0.5)
        first.wait("!document.body.innerText.includes('SENSOR_LOST, MRU (ended)')")

        second.click("take command")
        second.wait_for("Viewer 1 is in command. Take it over?")
        second.click("yes, do it")
        second.wait_for("you are in command")
        second.click("compensate")
        second.click("yes, do it")
        second.wait_for("mode compensating", 60.0)

        # the emergency stop is in reach wherever the page is scrolled to, and who is in command does not matter
        for tab in (first, second):
            tab.get("window.scrollTo(0, 1e6)")
            top = tab.get("document.querySelector('.emergency').getBoundingClientRect().top")
            assert 0.0 <= top < 300.0
        first.click("emergency stop")
        second.wait_for("emergency stop by the controller: the brake is on and the drum at rest", 30.0)
        assert first.complaints == []
        assert second.complaints == []

        assert first.get(PRESENT)
        served.kill()
        first.wait(f"!({PRESENT})", 5.0)
        assert first.text.startswith("NO CONNECTION") or "NO CONNECTION" in first.text
        served.wait()
        assert run.poll() is None, "the run goes on"


@pytest.fixture
def panel_of_a_winch(tmp_path):
    """Begin a run in real time with a winch of one's own, and a panel for it; return the panel's address."""
    with domain_id() as domain:
        general = ["--pacing", "realtime", "--duration", "3600", "--no-report", "--bag", str(tmp_path / "run")]
        log = (tmp_path / "run.log").open("w")
        run = subprocess.Popen(
            command("run", "b2_calm_300", "--replace", "virtual_winch=external", *general),
            env=environment(domain),
            stdout=log,
            stderr=log,
        )
        processes = [run, subprocess.Popen([sys.executable, str(WINCH)], env=environment(domain))]
        try:
            wait_until(lambda: " x real time" in (tmp_path / "run.log").read_text(), 180.0)
            served = subprocess.Popen(
                command("panel", "--port", "8078"), env=environment(domain), stdout=subprocess.PIPE, text=True
            )
            processes.append(served)
            yield served.stdout.readline().split()[-1]
        finally:
            for process in reversed(processes):
                process.send_signal(2)
                process.wait(60.0)


@pytest.mark.slow
@pytest.mark.long
@NEEDED
def test_a_winch_of_one_s_own_is_shown_stopped_and_released_and_no_fault_is_injected_into_it(
    panel_of_a_winch, tmp_path
):
    with Browser(tmp_path / "profile") as browser:
        tab = browser.tab()
        tab.size(1400, 900)
        tab.open(panel_of_a_winch)
        tab.wait_for("no viewer is in command; ")
        tab.click("take command")
        tab.wait_for("mode compensating", 180.0)
        values = "[...document.querySelectorAll('.heave-value')].map(value => value.innerText)"
        tab.wait(f"{values}.length === 7 && !{values}.includes('-')", 180.0)
        tab.wait("/efficiency, est. .%.[^]{0,3}[0-9.-]+/.test(document.body.innerText)")
        tab.wait("/winch speed: [+-][0-9.]+ of 2 m/.test(document.body.innerText)")
        tab.click("clear faults")
        tab.wait_for("load_cell: clear from")
        assert "encoder: clear" not in tab.text
        tab.click("emergency stop")
        tab.wait_for("emergency stop by the controller: the brake is on and the drum at rest")
        tab.click("compensate")
        tab.click("yes, do it")
        tab.wait_for("mode compensating", 120.0)
        assert tab.complaints == []
