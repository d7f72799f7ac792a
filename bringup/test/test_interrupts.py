"""An interrupt that a library swallows is not lost."""

import os
import signal
from contextlib import suppress

import pytest
from heave_bringup.interrupts import raise_if_interrupted, raise_interrupts
from heave_bringup.workers.pool import worker_pool


@pytest.fixture
def _raising():
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    raise_interrupts()
    yield
    raise_interrupts()
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
    raise_interrupts()
    raise_if_interrupted()
