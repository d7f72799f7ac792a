"""What a run does around its nodes: its folder, its ROS domain, the reason it gives, a second Ctrl-C."""

import os
import signal
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from types import SimpleNamespace

import pytest
from heave_bringup.network import only_run_in_domain
from heave_bringup.run import run
from heave_bringup.run.launcher import Launcher, NodeProcess
from heave_msgs.msg import TickStatus


def failed(name: str, words: str) -> SimpleNamespace:
    return SimpleNamespace(name=name, how_it_ended=lambda: words)


LOST = failed("recorder", "recorder: messages were lost: /mru 3 of 40")
HUNG = "wave_vessel has not finished tick 20: gave up after waiting 10 s at t = 1.0 s"


@pytest.mark.parametrize(
    ("nodes", "reason", "cause"),
    [
        ([LOST], HUNG, f"cable_sim: {HUNG}"),
        ([LOST], "", "recorder: messages were lost: /mru 3 of 40 at t = 1.05 s"),
        ([LOST, failed("mru", "mru was killed by SIGKILL")], HUNG, "mru was killed by SIGKILL at t = 1.05 s"),
        (
            [LOST, failed("virtual_winch", "virtual_winch: gave up at t = 1.0 s")],
            HUNG,
            "virtual_winch: gave up at t = 1.0 s",
        ),
    ],
)
def test_the_cause_that_is_told_is_the_first_one_and_not_what_followed(nodes, reason, cause):
    state = TickStatus.FAILED if reason else TickStatus.RUNNING
    monitor = SimpleNamespace(status=TickStatus(state=state, reason=reason, simulated_time=1.05))
    assert run._cause(nodes, monitor) == cause


def test_before_the_nodes_have_answered_the_progress_says_what_is_waited_for(capsys):
    monitor = SimpleNamespace(status=TickStatus(state=TickStatus.WAITING), kpi=None)
    run._show_progress(None, monitor, run.ProgressLine())
    assert capsys.readouterr().err == "waiting for the nodes to answer\n"


@pytest.mark.parametrize("external", [(), ("cable_sim",)])
@pytest.mark.parametrize("is_there", [True, False])
def test_a_first_run_says_that_the_plant_is_compiled(monkeypatch, is_there, external):
    """It stood for minutes at "starting the nodes"."""
    shown, scenario = [], SimpleNamespace(run=SimpleNamespace(external=external))
    monkeypatch.setattr(run, "is_compiled", lambda _: is_there)
    run._show_progress(scenario, SimpleNamespace(status=None, kpi=None), SimpleNamespace(show=shown.append))
    assert ("compiling" in shown[0]) is not (is_there or bool(external))


@pytest.mark.parametrize("has_bag", [True, False])
def test_a_node_that_does_not_end_fails_a_run_only_where_the_bag_is_not_closed(monkeypatch, tmp_path, capsys, has_bag):
    monkeypatch.setattr(run, "_show_progress", lambda *_: None)
    ended = TickStatus(state=TickStatus.ENDED)
    monitor = SimpleNamespace(spin=lambda _: None, status=ended, is_over=True, is_over_for=31.0, take_news=lambda: [])
    launcher = Launcher()
    for name, program in [("cable_sim", "sleep(60)"), ("recorder", "" if has_bag else "sleep(60)")]:
        process = subprocess.Popen([sys.executable, "-c", f"from time import sleep; {program}"])
        launcher.nodes.append(NodeProcess(name, process, tmp_path / "log", [name]))
    try:
        if has_bag:
            launcher.nodes[1].process.wait(timeout=30.0)
            folder = run.RunFolder(tmp_path)
            assert run._watch(None, folder, launcher, monitor, run.ProgressLine(), None) is ended
            assert "cable_sim did not exit within 30 s after the run and is ended" in capsys.readouterr().err
        else:
            with pytest.raises(run.CommandError, match="cable_sim, recorder did not exit within 30 s"):
                run._watch(None, run.RunFolder(tmp_path), launcher, monitor, run.ProgressLine(), None)
    finally:
        launcher.stop(grace=0.0)


def test_runs_that_begin_together_get_folders_of_their_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with ThreadPoolExecutor(8) as pool:
        folders = list(pool.map(lambda _: run.new_run_folder("calm", None).path, range(24)))
    assert sorted(folder.name for folder in folders) == [f"calm-{number:03d}" for number in range(1, 25)]


def test_of_two_runs_in_one_domain_the_second_is_told_and_after_the_first_it_may_run(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "231")
    with only_run_in_domain() as first:
        with only_run_in_domain() as second:
            assert (first, second) == (True, False)
        monkeypatch.setenv("ROS_DOMAIN_ID", "232")
        with only_run_in_domain() as elsewhere:
            assert elsewhere
        monkeypatch.setenv("ROS_DOMAIN_ID", "231")
    with only_run_in_domain() as after:
        assert after


def test_an_interrupt_that_comes_in_a_callback_of_the_middleware_ends_the_run_at_the_next_look():
    """The middleware swallows what a callback raises."""
    before = signal.getsignal(signal.SIGINT)
    watchdog = SimpleNamespace(beat=lambda: None, has_started=lambda: None)
    with run.interrupts_noted() as was_interrupted:
        look = run._until_started(watchdog, was_interrupted, None)
        look(None, None)
        with suppress(BaseException):
            os.kill(os.getpid(), signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            look(None, None)
    assert signal.getsignal(signal.SIGINT) is before


def test_a_second_interrupt_leaves_no_process(tmp_path):
    program = (
        "import signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN); print('on', flush=True); time.sleep(60)"
    )
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE)
    process.stdout.read(2)
    before = signal.getsignal(signal.SIGINT)
    launcher = Launcher()
    launcher.nodes.append(NodeProcess("wave_vessel", process, tmp_path / "log", ["wave_vessel"]))
    interrupts = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
    interrupts.start()
    with run.interrupts_skip_grace(launcher):
        launcher.stop(grace=1e6)
    assert process.poll() == -signal.SIGKILL
    assert signal.getsignal(signal.SIGINT) is before
