"""What the tests with processes share."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # the tests share helper modules, and are no package

from loop_processes import Loop


@pytest.fixture
def loop():
    from domain_coordinator import domain_id  # noqa: PLC0415 - tests without processes do without it

    with domain_id() as domain:
        loop = Loop(domain)
        yield loop
        loop.stop()
