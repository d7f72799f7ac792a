"""An interrupt that a library swallows is not lost."""

import os
import signal
import subprocess
import sys
from contextlib import suppress

import pytest
from heave_bringup.interrupts import forget_interrupts, raise_if_interrupted, raise_interrupts
from heave_studies.workers.pool import worker_pool


@pytest.fixture
def _raising():
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    raise_interrupts()
    yield
    forget_interrupts()
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.usefixtures("_raising")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_that_an_import_has_swallowed_ends_the_command_before_its_work_begins(number):
    raise_if_interrupted()
    with suppress(BaseException):  # as compiled modules do
        os.kill(os.getpid(), number)
    with pytest.raises(KeyboardInterrupt):
        raise_if_interrupted()
    with pytest.raises(KeyboardInterrupt), worker_pool(1):
        pass
    forget_interrupts()
    raise_if_interrupted()


STARTED = """
import os, signal, weakref
class Locked: pass
lock = Locked()
reference = weakref.ref(lock, lambda _: os.kill(os.getpid(), signal.SIGINT))
import heave_bringup.interrupts
del lock
from heave_bringup.cli import main
main(["list"])
"""


def test_an_interrupt_that_comes_while_the_command_is_imported_ends_it_with_its_status():
    """In a callback, of which Python says that an exception is ignored."""
    done = subprocess.run([sys.executable, "-c", STARTED], capture_output=True, text=True, timeout=120, check=False)
    assert "KeyboardInterrupt" in done.stderr
    assert done.stderr.endswith("heave: interrupted\n")
    assert done.stdout == ""
