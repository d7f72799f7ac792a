"""An interrupt that a library swallows is not lost."""

import os
import signal
import subprocess
import sys
from contextlib import suppress

import pytest
from heave_bringup.interrupts import forget_interrupts, raise_if_interrupted, raise_interrupts
from heave_studies.study.workers import workers


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
    with pytest.raises(KeyboardInterrupt), workers(1):
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


IMPORTING = """
import sys
import heave_bringup.interrupts
from heave_bringup.cli import main
main(["list"])
"""
INTERRUPTED_MODULE = """
import os, signal, sys, time
def callback(_): os.kill(os.getpid(), signal.SIGINT)
class Locked: pass
import weakref
lock = Locked()
reference = weakref.ref(lock, callback)
del lock
time.sleep(0.1)
os.write(1, b"imported\\n")
"""


@pytest.mark.parametrize("module", ["argparse", "heave_bringup.output"])
def test_an_import_is_over_before_an_interrupt_is_raised_and_nothing_but_a_line_is_said(tmp_path, module):
    """Of a module of Python that a command imports first, and of one that it imports to do its work.

    The signal comes in a callback, as of the locks of the imports: what is raised there is shown as a traceback.
    """
    (tmp_path / "interrupted.py").write_text(INTERRUPTED_MODULE)
    program = f"""
import sys
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            sys.meta_path.remove(self)
            import interrupted
sys.modules.pop({module!r}, None)
sys.meta_path.insert(0, Finder())
{IMPORTING}
"""
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False, env=environment
    )
    assert (done.stdout, done.stderr) == ("imported\n", "heave: interrupted\n")
    assert done.returncode == 0, "main returns the status; a program of its own need not end by it"
