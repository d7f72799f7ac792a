"""A sample of the campaign of hostile files: no traceback, bounded in memory and time, nothing written elsewhere."""

from __future__ import annotations

import pytest

from tests.campaigns import hostile_files


@pytest.mark.slow
def test_scenarios_tables_and_attachments_of_anybody_are_read_or_refused_in_one_line():
    results = hostile_files.campaign(6, lambda _: None, first=2001)
    assert [result.kind for result in results] == list(hostile_files.KINDS) * 2
    assert {result.number: result.wrong for result in results if result.wrong} == {}
    assert max(result.memory for result in results) < hostile_files.MEMORY
