"""The drawing of a lift in its report moves as the bag says, weighs little, and needs nothing but the page."""

import base64
import json

import numpy as np
import pytest
from heave_bags.analyse import analysis
from heave_bags.report import report
from heave_bags.report.lift import MOST, REACH, lift_drawing
from heave_bags.signals import Signal

from tests import browser


@pytest.fixture
def record(shared_bag):
    """Return a run of 2,104 s: boom tip 1 m, locked load 2 m, load 1 cm, all at 8 s."""
    (found,) = analysis.analyse([shared_bag])
    time = np.arange(0.0, 2104.0, 0.05)  # whole periods from 120 s on
    wave = np.sin(2.0 * np.pi * time / 8.0)
    found.start, found.end = 120.0, 2104.0
    for name, amplitude in (("boom_tip", 1.0), ("uncompensated", 2.0), ("unit", 0.01)):
        setattr(found.signals, f"{name}_heave", Signal(time, amplitude * wave))
    found.signals.payout = Signal(time, wave)
    return found


def unpacked(packed) -> np.ndarray:
    return packed["unit"] * np.frombuffer(base64.b64decode(packed["int16"]), "<i2")


def test_the_motions_of_the_drawing_are_those_of_the_bag(record):
    motion = lift_drawing(record)["motion"]
    time = motion["start"] + motion["step"] * np.arange(motion["count"])
    for name, amplitude in (("tip", 1.0), ("locked", 2.0), ("load", 0.01), ("payout", 1.0)):
        expected = amplitude * np.sin(2.0 * np.pi * time / 8.0)
        assert unpacked(motion["columns"][name]) == pytest.approx(expected, abs=2e-3 * amplitude)


def test_half_an_hour_weighs_tens_of_kilobytes_and_a_day_no_more_than_an_hour(record):
    drawing = lift_drawing(record)
    assert len(json.dumps(drawing)) < 60_000
    time = np.arange(0.0, 86_400.0, 1.0)
    record.signals.unit_heave = Signal(time, np.sin(time))
    assert lift_drawing(record)["motion"]["count"] <= MOST


def test_the_page_of_a_run_has_the_drawing_and_that_of_a_comparison_has_none(record):
    page = report.render([record])
    assert 'id="lift-play"' in page
    assert 'id="lift-play"' not in report.render([record, record])
    record.signals.unit_heave = Signal()
    assert 'id="lift-play"' not in report.render([record]), "no load was recorded"


@browser.NEEDED
@pytest.mark.parametrize("width", [1200, 420])
def test_the_drawing_plays_and_the_slider_moves_it(record, tmp_path, width):
    report.save_report([record], tmp_path / "report.html")
    locked = "document.getElementById('lift-locked').getAttribute('transform')"
    slide = "(e => {{ e.value = {}; e.dispatchEvent(new Event('input')); }})(document.getElementById('lift-time'))"
    with browser.Browser(tmp_path / "browser") as chromium:
        tab = chromium.tab()
        tab.size(width, 900)
        tab.open((tmp_path / "report.html").as_uri())
        tab.wait("document.body && document.body.dataset.ready === 'true'")
        assert tab.get("document.documentElement.scrollWidth") <= width
        tab.get(slide.format(4))  # 2 s, a crest of 2 m
        up = tab.get(locked)
        tab.get(slide.format(12))  # 6 s, a trough
        down = tab.get(locked)
        assert float(up[len("translate(0 ") : -1]) == pytest.approx(-REACH, rel=0.01), "up is up"
        assert float(down[len("translate(0 ") : -1]) == pytest.approx(REACH, rel=0.01)
        assert "load -1.0 cm, with the winch locked -200.0 cm" in tab.get(
            "document.getElementById('lift-now').textContent"
        )
        tab.get("document.getElementById('lift-play').click()")
        tab.wait("Number(document.getElementById('lift-time').value) > 14")
        shown = tab.get("document.getElementById('lift-play').textContent")
        assert shown == "\u2016", "the sign for pause is an emoji, which a machine without such a font shows as a box"
        assert tab.complaints == []
