"""What stands beside the figures of an answer."""

from types import SimpleNamespace

import numpy as np
import pytest
from heave_bringup.whatif import fitness


@pytest.mark.parametrize(("band", "is_warned"), [((0.95, 0.99), False), ((0.62, 0.82), True)])
def test_an_efficiency_that_the_record_does_not_tell_is_said_to_be_unknown(monkeypatch, band, is_warned):
    monkeypatch.setattr(fitness, "reported", lambda known: [("winch limits", True, "")])
    again = SimpleNamespace(is_same=True, refused=())
    past = SimpleNamespace(record=SimpleNamespace(has_orders=True, is_own=True))
    known = SimpleNamespace(fit=SimpleNamespace(chi2=1.0), snapped=np.zeros(3), again=again, past=past)
    figures = SimpleNamespace(values={"time_at_limit_percent": 0.0}, bands={"unit_efficiency": band})
    asked, done = SimpleNamespace(name="industrial"), SimpleNamespace(refused=())
    lines = fitness.warnings(known, [SimpleNamespace(asked=asked, figures=figures, done=done)])
    assert lines == (["industrial: the record does not tell its efficiency: 62 to 82 %"] if is_warned else [])
