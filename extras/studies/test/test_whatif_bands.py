"""Bands of what would have been, against sums by hand."""

import numpy as np
import pytest
from heave_studies.whatif.answer import Figures, Spread, with_bands


def test_motion_by_an_unknown_boom_tip_may_be_none() -> None:
    # 5 mm, 3 mm of them added for what is not known of the tip: sqrt(25 - 9) = 4 mm without; 1 mm of 100 is 1 point
    base = Figures({"unit_sigma_m": 0.005, "unit_efficiency": 0.95}, np.zeros(2), {}, np.inf, "")
    certain = Spread(loops=[], plants=[], added=0.0, locked=0.0, model=0.0)
    bands = with_bands(base, certain, 0.1, by_tip=0.003).bands
    assert bands["unit_sigma_m"] == pytest.approx((0.004, 0.005))
    assert bands["unit_efficiency"] == pytest.approx((0.95, 0.96))


def test_what_cannot_be_below_zero_is_not_in_a_band() -> None:
    # 0.3 m/s off in the one draw: half a band of 1.645 x 2.5 x 0.3 = 1.23 m/s
    base = Figures({"unit_sigma_m": 0.1, "unit_efficiency": 0.5, "winch_speed_max_mps": 0.6}, np.zeros(2))
    loops = [{"unit_sigma_m": 0.0, "unit_efficiency": 0.0, "winch_speed_max_mps": 0.3}]
    bands = with_bands(base, Spread(loops=loops, plants=[], added=0.0, locked=0.0, model=0.0), 0.2).bands
    assert bands["winch_speed_max_mps"] == pytest.approx((0.0, 0.6 + 1.23375))
