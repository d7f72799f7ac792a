"""An operator at a run that is under way: every verb of `heave operate`, over ROS."""

import json
import subprocess

import pytest
from domain_coordinator import domain_id
from heave_bags.analyse.read_run import read_run

from tests.loop_runs import command, environment, wait_until


class Operator:
    """A terminal beside the run."""

    def __init__(self, domain):
        self._environment = environment(domain)

    def __call__(self, *words):
        return subprocess.run(
            command("operate", *words), env=self._environment, capture_output=True, text=True, timeout=120, check=False
        )

    def must(self, *words):
        done = self(*words)
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    def refused(self, *words):
        done = self(*words)
        assert done.returncode == 1, done.stdout
        assert done.stderr.count("\n") == 1
        return done.stderr.strip()

    def status(self):
        return json.loads(self.must("status", "--json", "-"))


@pytest.mark.slow
@pytest.mark.long
def test_every_verb_has_a_definite_answer_at_a_run_under_way(tmp_path):
    with domain_id() as domain:
        operator = Operator(domain)
        nobody = operator("status")
        assert nobody.returncode == 2
        assert f"no run in ROS domain {domain}" in nobody.stderr
        settings = ["--set", "recorder.snapshot_duration=20", "--set", "winch_controller.modes.start=standby"]
        # lockstep: a machine under load is slow, but no message comes late
        general = ["--pacing", "lockstep", "--duration", "20000", "--no-report", "--bag", str(tmp_path / "run")]
        log = (tmp_path / "log").open("w")
        run = subprocess.Popen(
            command("run", "b2_calm_300", *general, *settings), env=environment(domain), stdout=log, stderr=log
        )
        try:
            wait_until(lambda: "running at" in operator("status").stdout, 120.0)
            use_every_verb(operator, tmp_path)
        finally:
            run.terminate()
            run.wait(60.0)
        requests = [one.name for one in read_run(tmp_path / "run").requests]
        assert "fault of mru: freeze for 30 s" in requests
        assert "fault of mru: clear" in requests


def use_every_verb(operator, folder):
    wait_until(lambda: operator.status()["depth"] is not None, 30.0)
    assert "a move needs mode compensating; the mode is standby" in operator.refused("move", "1")
    assert "compensating" in operator.must("mode", "compensating")
    wait_until(lambda: operator.status()["controller"]["mode"] == "compensating", 60.0)
    assert "factor 0.5" in operator.must("factor", "0.5")
    wait_until(lambda: operator.status()["controller"]["authority"] == pytest.approx(0.5), 60.0)
    before = operator.status()["depth"]
    assert "arrived" in operator.must("move", "0.5", "--speed", "0.4")
    assert operator.status()["depth"] == pytest.approx(before + 0.5, abs=0.05)
    assert "arrived: mean depth" in operator.must("depth", f"{before:.2f}")
    assert "under way" in operator.must("move", "5", "--speed", "0.001", "--no-wait")
    assert "another one is under way" in operator.refused("move", "1")
    assert "ends smoothly" in operator.must("hold")
    assert "no move is under way" in operator.refused("hold")
    assert "the winch reaches" in operator.refused("depth", "5000")
    assert "the mean payout moved by -0." in operator.must("speed", "-0.2", "--for", "2")
    assert "predicted unit heave" in operator.must("redesign", "--height", "2", "--period", "9")
    assert "not paused" in operator.refused("step")
    assert "paused at" in operator.must("pause")
    tick = operator.status()["run"]["tick"]
    operator.must("step", "20")
    assert operator.status()["run"]["tick"] == tick + 20
    assert "running at" in operator.must("resume")
    saved = operator.must("snapshot", "--seconds", "5", "--directory", str(folder / "snapshot"))
    assert "messages in" in saved
    assert (folder / "snapshot" / "metadata.yaml").is_file()
    assert "mru: freeze from" in operator.must("fault", "inject", "mru", "freeze", "--duration", "30")
    assert "has no device velocity" in operator.refused("fault", "inject", "velocity", "nan")
    assert "mru: clear from" in operator.must("fault", "clear", "all")
    assert "stopped at" in operator.must("stop")
    answer = json.loads(operator.must("emergency-stop", "--json", "-"))
    assert answer["done"]
    assert operator.status()["controller"]["mode"] == "emergency_stop"
    assert operator.status()["winch"]["brake"] is True
