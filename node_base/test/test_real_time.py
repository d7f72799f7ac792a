"""Garbage between ticks, and what the machine is asked for in real time."""

import gc
import os
import subprocess
import sys
import weakref
from types import SimpleNamespace

import pytest
from heave_node.ros import process
from heave_node.ros.transport.real_time import MIDDLE_AGED, MUCH, OLD, after_tick, collect_between_ticks

PRIORITY = """
import os, resource, sys, threading
from heave_node.ros.transport.real_time import take_priority

held = threading.Event()
threading.Thread(target=held.wait, daemon=True).start()
if "without" in sys.argv:
    resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
    resource.setrlimit(resource.RLIMIT_MEMLOCK, (0, 0))
    os.setuid(65534)
for refused in take_priority(7):
    print("refused:", refused)
for thread in os.listdir("/proc/self/task"):
    print(os.sched_getscheduler(int(thread)) == os.SCHED_FIFO and os.sched_getparam(int(thread)).sched_priority)
def kilobytes(name):
    return int(next(line.split()[1] for line in open("/proc/self/status") if line.startswith(name)))

print("locked:", kilobytes("VmLck"))
resident = kilobytes("VmRSS")
threading.Thread(target=held.wait, daemon=True).start()
print("filled:", kilobytes("VmRSS") - resident)
"""
is_root = pytest.mark.skipif(os.getuid() != 0, reason="only root may give up and take what is asked for here")


class Cycle:
    """An object that only the collector of garbage can free."""

    def __init__(self):
        self.myself = self


@pytest.fixture(autouse=True)
def _leave_the_collector_on():
    yield
    gc.enable()
    gc.unfreeze()


def leave_garbage(count):
    return [weakref.ref(Cycle()) for _ in range(count)]


def alive(garbage):
    return sum(reference() is not None for reference in garbage)


def test_garbage_waits_for_the_end_of_the_tick_however_much_there_is():
    collect_between_ticks()
    garbage = leave_garbage(100 * gc.get_threshold()[0])
    assert alive(garbage) == len(garbage)
    after_tick()
    assert alive(garbage) == 0


def test_what_outlived_some_ticks_is_collected_too():
    collect_between_ticks()
    kept = [Cycle() for _ in range(10)]
    garbage = [weakref.ref(cycle) for cycle in kept]
    for _ in range(10):
        after_tick()  # they grow old
    kept.clear()
    for _ in range(2 * OLD * MIDDLE_AGED):
        after_tick()
    assert alive(garbage) == 0


def test_garbage_of_a_node_that_waits_is_collected_too():
    """Without ticks, as long as somebody is missing or the run is paused; what a tick leaves waits for its end."""
    node = SimpleNamespace(on_idle=lambda: None, look_for_hearers=lambda: None)
    collect_between_ticks()
    garbage = leave_garbage(1000)
    process._on_idle(node)
    assert alive(garbage) == len(garbage)
    garbage = leave_garbage(MUCH)
    process._on_idle(node)
    assert alive(garbage) == 0


def test_a_node_in_lockstep_leaves_the_collector_as_it_is():
    after_tick()
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0


def run(*arguments):
    return subprocess.run(
        [sys.executable, "-c", PRIORITY, *arguments], capture_output=True, text=True, check=True
    ).stdout.splitlines()


@is_root
def test_every_thread_gets_the_priority_and_the_memory_is_locked():
    *threads, locked, _ = run()
    if any(line.startswith("refused") for line in threads):
        pytest.skip("this machine permits it to nobody")
    assert threads == ["7", "7"]
    assert int(locked.removeprefix("locked:")) > 0


@is_root
def test_the_stack_of_a_later_thread_is_not_filled_at_once():
    """8 MB each, and the next 16 MB of a heap: the first ticks of a run at 100 Hz were late by 0.3 s."""
    *_, filled = run()
    assert int(filled.removeprefix("filled:")) < 1000


@is_root
def test_what_is_not_permitted_is_named_with_the_remedy():
    memory, priority, *threads, locked, _ = run("without")
    assert "memlock unlimited" in memory
    assert "rtprio 7" in priority
    assert threads == ["False", "False"]
    assert locked == "locked: 0"
