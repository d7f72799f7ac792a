"""A run on two hosts, which are network namespaces here: clocks that differ, a link that drops or is slow.

What each test finds is what docs/guide/howto/several_hosts.md says.
"""

import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from heave_bags.mcap.reader import Bag

from tests.hosts import Host, drop_link, stop, two_hosts, why_not
from tests.loop_runs import HAS_RUN, command

UNABLE = why_not()
pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(UNABLE), reason=UNABLE)]

LOOP = Path(__file__).parents[1] / "node_base" / "test" / "loop_program.py"
PEERS = ("wave_vessel", "winch_controller", "virtual_winch")
SUBNET = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}

AHEAD = 0.5
CLOCK_AHEAD = f"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <sys/time.h>
#include <time.h>
static const long ahead = {AHEAD} * 1000000000L;
int clock_gettime(clockid_t clock, struct timespec *now) {{
    static int (*real)(clockid_t, struct timespec *);
    if (!real) real = dlsym(RTLD_NEXT, "clock_gettime");
    int result = real(clock, now);
    if (clock == CLOCK_REALTIME) {{
        long nanoseconds = now->tv_nsec + ahead;
        now->tv_sec += nanoseconds / 1000000000L;
        now->tv_nsec = nanoseconds % 1000000000L;
    }}
    return result;
}}
"""
"""A library that puts the clock of a process ahead, as the clock of its host would be [s]."""


@pytest.fixture
def started():
    """Processes that are killed at the end of the test, whatever comes."""
    processes: dict[str, subprocess.Popen[str]] = {}
    yield processes
    stop(*processes.values())


@pytest.fixture
def hosts():
    with two_hosts() as pair:
        yield pair


def start(hosts: tuple[Host, Host], started, *, winch_environment=None, **parameters: object) -> None:
    """Start the loop of four processes: the winch on the second host, all else on the first."""
    given = {"participants": f"[{', '.join(PEERS)}]", **parameters}
    ros = ["--ros-args", *(part for name, value in given.items() for part in ("-p", f"{name}:={value}"))]
    for name in (*PEERS, "cable_sim"):
        is_winch = name == "virtual_winch"
        environment = {**SUBNET, **((winch_environment or {}) if is_winch else {})}
        host = hosts[1] if is_winch else hosts[0]
        started[name] = host.start(sys.executable, str(LOOP), name, *ros, environment=environment)


def end(started, name: str) -> tuple[int, str, str]:
    out, err = started[name].communicate(timeout=120.0)
    return started[name].returncode, out, err


@pytest.fixture(scope="session")
def clock_ahead(tmp_path_factory) -> dict[str, str]:
    """Return an environment in which the clock is AHEAD."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("a clock that is ahead needs a C compiler")
    folder = tmp_path_factory.mktemp("clock")
    (folder / "ahead.c").write_text(CLOCK_AHEAD)
    library = folder / "ahead.so"
    command = [compiler, "-shared", "-fPIC", "-o", str(library), str(folder / "ahead.c"), "-ldl"]
    subprocess.run(command, check=True)
    return {"LD_PRELOAD": str(library)}


def test_a_clock_that_is_too_far_from_the_masters_is_refused_in_one_line(hosts, started, clock_ahead):
    start(hosts, started, winch_environment=clock_ahead, pacing="realtime", strict=False, duration=3.0)
    status, _, err = end(started, "cable_sim")
    assert status == 1
    found = re.search(r"cable_sim: the clock of virtual_winch's host \S+ is (\S+) s ahead of this host's", err)
    assert found, err
    assert abs(float(found[1]) - AHEAD) < 0.1, "the limit below which it would not be refused"


def test_in_lockstep_the_offset_of_a_clock_is_shown(hosts, started, clock_ahead):
    start(hosts, started, winch_environment=clock_ahead, duration=2.0)
    status, out, err = end(started, "cable_sim")
    assert status == 0, err
    assert "ended=True ticks=41" in out
    assert re.search(r"clocks of other hosts, ahead of this one's: virtual_winch on \S+ \+[45]\d\d\.\d ms", err), err


def wait_for_ticks(started, seconds: float) -> None:
    """Wait until the run has begun, which the master says of the hosts' clocks, and some time more."""
    for line in started["cable_sim"].stderr:
        if "clocks of other hosts" in line:
            break
    time.sleep(seconds)
    assert started["cable_sim"].poll() is None, "the run is still under way"


DROPS = [0.1, pytest.param(1.0, marks=pytest.mark.long), pytest.param(10.0, marks=pytest.mark.long)]


@pytest.mark.parametrize("seconds", DROPS)
def test_in_lockstep_a_run_waits_for_a_link_that_was_down_and_loses_nothing(hosts, started, seconds):
    ticks = 1400
    start(hosts, started, duration=ticks * 0.05)
    wait_for_ticks(started, 0.5)
    drop_link(hosts, seconds)
    status, out, err = end(started, "cable_sim")
    assert status == 0, err
    assert f"ended=True ticks={ticks + 1} epoch=1 sum={sum(range(1, ticks + 1))}" in out, "each message, once"


@pytest.mark.long
@pytest.mark.parametrize("seconds", [0.1, 1.0, 10.0])
def test_in_real_time_a_run_goes_on_without_a_link_and_with_it_again(hosts, started, seconds):
    start(hosts, started, pacing="realtime", strict=False, duration=seconds + 15.0)
    wait_for_ticks(started, 3.0)
    drop_link(hosts, seconds)
    status, out, err = end(started, "cable_sim")
    assert status == 0, err
    assert f"ended=True ticks={round((seconds + 15.0) / 0.05) + 1}" in out
    missed = int(out.split("missed=")[1].split()[0])
    assert missed >= seconds / 0.05 - 1


def test_in_lockstep_a_slow_link_slows_the_run_and_loses_nothing(hosts, started):
    for host in hosts:
        host.send_slowly("1mbit")
    start(hosts, started, duration=20.0)
    status, out, err = end(started, "cable_sim")
    assert status == 0, err
    assert f"ended=True ticks=401 epoch=1 sum={sum(range(1, 401))}" in out, "each message of 400 ticks, once"


WINCH = Path(__file__).parents[1] / "examples" / "winch.py"


@pytest.mark.long
@pytest.mark.parametrize(("seconds", "stops"), [(0.1, False), (1.0, True), (10.0, True)])
def test_a_winch_on_another_host_stops_where_the_link_is_down_for_longer_than_its_watchdog(
    hosts, started, tmp_path, seconds, stops
):
    options = [
        "--pacing",
        "realtime",
        "--duration",
        "130",
        "--network",
        "--replace",
        "virtual_winch=external",
        "--no-report",
    ]
    for setting in ("winch_controller.modes.settling_time=5", "wave_vessel.ramp=5", "all.transient=30"):
        options += ["--set", setting]
    run = hosts[0].start(*command("run", "b2_calm_300", "--bag", str(tmp_path / "run"), *options))
    started["winch"] = hosts[1].start(sys.executable, str(WINCH), environment=SUBNET)
    started["run"] = run
    said = re.compile(r"(\d+\.\d) s of 130 s.*compensating")
    times = (float(found[1]) for found in map(said.search, run.stderr) if found)
    dropped = next(time for time in times if time > 40.0)
    drop_link(hosts, seconds)
    _, err = run.communicate(timeout=400.0)  # it is judged too, on a machine that may be busy
    assert run.returncode in HAS_RUN, err
    found = Bag(tmp_path / "run" / "bag").columns({"/winch/state": ["fault", "brake"], "/controller/state": ["mode"]})
    winch, controller = found["/winch/state"], found["/controller/state"]
    # what is said of a run is some tenths of a second old; at other times a busy machine may hold commands up
    then = (winch["time"] > dropped - 1.0) & (winch["time"] < dropped + seconds + 5.0)
    timed_out = then & (winch["fault"] == 1)
    assert timed_out.any() == stops, "FAULT_COMMAND_TIMEOUT, after the 0.5 s of its watchdog"
    assert winch["brake"][then].any() == stops
    later = controller["time"] > (winch["time"][timed_out].max() if stops else dropped)
    assert "compensating" in controller["mode"][later], "it goes on by itself"
