"""What the tests with processes share."""

import sys
from pathlib import Path

import pytest
from domain_coordinator import domain_id

sys.path.insert(0, str(Path(__file__).parent))  # the tests share helper modules, and are no package

from loop_processes import Loop


@pytest.fixture
def loop():
    with domain_id() as domain:
        loop = Loop(domain)
        yield loop
        loop.stop()
