"""The report: one offline file that a real browser draws without a complaint."""

import math
import re
import subprocess
from dataclasses import replace

import pytest
from heave_bags.analyse import analysis, differences, kpi_set, run_words
from heave_bags.analyse.events import Interval
from heave_bags.analyse.reading.innovations import Innovation
from heave_bags.errors import BagError
from heave_bags.report import paper, report
from heave_bags.report.figure import pack, thin
from heave_bags.report.report_figures import comparison_figures, innovation_figure, run_figures
from heave_bags.signals import Signal
from heave_node.criteria import Criterion
from made_up_run import SCENARIO, MadeUpRun, write_run
from numpy import arange, array, sin, where, zeros

from tests import browser

FLAGS = (*browser.FLAGS, "--enable-logging=stderr", "--virtual-time-budget=20000")


def browse(page, tmp_path) -> tuple[str, list[str]]:
    """Return the page as a browser has drawn it, and what its console said."""
    command = [browser.CHROMIUM, *FLAGS, f"--user-data-dir={tmp_path / 'profile'}", "--dump-dom", page.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


@browser.NEEDED
def test_a_browser_draws_every_figure_without_a_word_on_the_console(made_up_bag, tmp_path):
    bags = [made_up_bag("good"), made_up_bag("bad", MadeUpRun(unit=0.2))]
    records = analysis.analyse(bags)
    report.save_report(records, tmp_path / "report.html")
    drawn, console = browse(tmp_path / "report.html", tmp_path)
    assert console == []
    assert 'data-ready="true"' in drawn
    figures = 2 + sum(len(run_figures(record)) for record in records)  # two of both
    assert drawn.count('class="plot-container') == figures
    assert "NaN" not in re.sub(r"<script.*?</script>", "", drawn, flags=re.DOTALL)


def test_the_page_needs_nothing_from_outside(shared_bag):
    page = report.render(analysis.analyse([shared_bag]))
    head = page[: page.index("<script>")] + page[page.rindex("<script>") :]
    assert not re.search(r"(src|href)=[\"'](?!data:)", head)


def test_the_page_says_what_was_lost_and_escapes_names(shared_bag):
    (record,) = analysis.analyse([shared_bag])
    record.name, record.notes = "<b>bag</b>", ["the run did not end normally: <killed>"]
    page = report.render([record, record])
    assert "&lt;killed&gt;" in page
    assert "<b>bag</b>" not in page[: page.index("<script>")]


@browser.NEEDED
def test_a_browser_runs_nothing_that_a_bag_brings_into_the_page(shared_bag, tmp_path):
    (record,) = analysis.analyse([shared_bag])
    evil = "</script><script>document.body.dataset.evil=1</script><img src=x onerror=document.body.dataset.evil=1>"
    record.name, record.notes, record.run = evil, [evil], {"scenario": evil}
    record.modes = [Interval(0.0, 60.0, evil)]
    page = tmp_path / "report.html"
    report.save_report([record], page)
    drawn, console = browse(page, tmp_path)
    assert console == [], "nothing even tries: it is all text"
    page.write_text(page.read_text().replace("</footer>", "</footer><script>document.body.dataset.evil=1</script>"))
    drawn, console = browse(page, tmp_path)
    assert "data-evil" not in drawn.split("<footer")[0]
    assert "Content Security Policy" in console[0]


def test_the_figures_of_merit_stand_in_groups_and_those_nobody_knows_are_left_out(shared_bag):
    (record,) = analysis.analyse([shared_bag])
    record.run = {"pacing": "realtime"}
    page = report.render([record])
    shown = re.findall(r'class="group"[^>]*>([^<]+)<', page)
    assert shown == [group for group in kpi_set.GROUPS if group in shown]
    assert {"Load", "Tension", "Winch", "Energy"} <= set(shown)
    rows = [definition for definition in kpi_set.KPI_DEFINITIONS if math.isfinite(record.kpis()[definition.key])]
    table = page[page.index('id="kpis"') : page.index("What happened")]
    hidden = {"landings", "landings_held", "compensation_losses", "mode_changes"}  # nothing of that happened
    assert table.count("<tr><td>") == len([row for row in rows if row.key not in hidden and not row.is_seldom])


def test_wall_time_is_left_out_of_what_people_see_of_a_run_in_lockstep(shared_bag):
    (record,) = analysis.analyse([shared_bag])
    for pacing, is_shown in (("lockstep", False), ("realtime", True)):
        record.run = {"pacing": pacing}
        for text in (report.render([record]), analysis.table([record])):
            assert ("control latency, largest" in text) is is_shown
            assert ("missed deadlines" in text) is is_shown
        assert analysis.to_json(record)["missed_deadlines"] == 0.0


def test_an_event_is_shown_as_one_by_its_code(shared_bag):
    (record,) = analysis.analyse([shared_bag])
    part = "winch_controller: alarms: "
    limited = "AUTHORITY_LIMITED (medium): authority limited to 30 %."
    record.alarms = [Interval(20.0, 21.0, f"{part}AUTHORITY_RESTORED (event): authority is 100 % again.")]
    record.alarms += [Interval(30.0, 31.0, f"{part}{limited}", level=1)]
    page = report.render([record])
    assert "<td>event: AUTHORITY_RESTORED: authority is 100 % again.</td>" in page
    assert f"<td>warning: {limited}</td>" in page


def test_the_report_begins_with_what_was_run_the_verdict_and_eight_figures(shared_bag):
    (record,) = analysis.analyse([shared_bag])
    record.wanted = (Criterion("unit_sigma_m", "<=", 0.01),)
    record.end = record.start + 60.0  # long enough to be judged
    page = report.render([record])
    head = page[page.index("<header>") : page.index("</header>")]
    head = head.replace("\N{NO-BREAK SPACE}", " ")
    assert "verdict: FAILED" in head
    assert 'class="verdict bad"' in head
    assert head.count("at most 1 cm") == 2, "in the verdict, and beside the figure in its unit"
    assert head.count('class="tile"') == 7
    assert head.count('class="tile missed"') == 1
    assert page.index("<h3>Motion") < page.index("Figures of merit")


def test_a_motion_has_one_unit_in_table_extremes_axes_and_under_the_pointer(shared_bag):
    (record,) = analysis.analyse([shared_bag])
    units = {one.unit for one in kpi_set.KPI_DEFINITIONS if one.key.endswith("_m")}
    assert units == {"cm"}
    assert {extreme.shown[1] for extreme in analysis.extremes(record) if extreme.unit == "m"} == {"cm"}
    assert {one.unit for one in kpi_set.KPI_DEFINITIONS if one.key.endswith("_n")} == {"kN"}
    for row, name in zip(record.innovations, ("mru_heave", "unit_heave"), strict=True):
        row.name = name  # as the controller calls them
    for figure in run_figures(record):
        drawn = figure.to_mapping()
        axes = [axis for name, axis in drawn["layout"].items() if name.startswith("yaxis") and "title" in axis]
        assert all("[" in axis["title"]["text"] for axis in axes), figure.title
        for trace in drawn["traces"]:
            if trace.get("yaxis", "y") == "y" and "heave" in drawn["layout"]["yaxis"]["title"]["text"]:
                assert trace["hovertemplate"].endswith((" cm", "</extra>"))
    innovations = innovation_figure(record)
    assert innovations is not None
    assert {"MRU heave", "load heave"} <= {str(trace["name"]) for trace in innovations.traces}


LIFT = SCENARIO.replace(b"{transient:", b"{title: 'Template <T4>', description: 'Lowered by crane 2.', transient:")


def test_the_title_and_description_of_the_lift_are_at_the_head(tmp_path):
    write_run(tmp_path / "run", scenario=b"# A line at its head.\n" + LIFT)
    (record,) = analysis.analyse([tmp_path / "run"])
    page = report.render([record])
    assert "<h1>Template &lt;T4&gt;</h1>" in page
    assert "Lowered by crane 2.</p>" in page
    write_run(tmp_path / "plain", scenario=b"# A line at its head.\n" + SCENARIO)
    (record,) = analysis.analyse([tmp_path / "plain"])
    assert (record.title, record.description) == ("", "A line at its head.")
    write_run(tmp_path / "long", scenario=b"# " + b"x" * 10**6 + b"\n" + SCENARIO)
    (record,) = analysis.analyse([tmp_path / "long"])
    assert len(record.description) <= 1000, "what a bag brings has a bound"


def test_the_industrial_baseline_is_among_the_large_figures(shared_bag):
    (record,) = analysis.analyse([shared_bag])
    record.signals.baseline = replace(record.signals, baseline=None)
    page = report.render([record])
    head = page[page.index("<header>") : page.index("</header>")]
    assert head.count('<div class="tile" ') == 8
    assert "efficiency at the load, industrial controller" in head


def test_modes_limits_and_alarms_have_a_legend_that_needs_no_pointer(shared_bag):
    (record,) = analysis.analyse([shared_bag])
    record.modes = [Interval(0.0, 9.0, "standby"), Interval(9.0, 30.0, "fade_out"), Interval(30.0, 60.0, "<mode>")]
    record.limits = [Interval(1.0, 2.0, "brake"), Interval(20.0, 21.0, "speed"), Interval(25.0, 26.0, "torque")]
    record.alarms = [Interval(20.0, 21.0, "words", 1)]
    page = report.render([record])
    legend = re.search(r'<ul class="legend">(.*?)</ul>', page, re.DOTALL).group(1)
    shown = re.findall(r"</i>([^<]*)</li>", legend)
    assert shown[:3] == ["mode standby", "mode fade out", "mode &lt;mode&gt;"]
    assert shown[3:] == ["brake on", "winch at a limit: speed, torque", "alarm, warning", "transient, not counted"]
    assert "print-color-adjust: exact" in page, "browsers leave backgrounds off paper else"
    record.modes = [Interval(float(n), n + 1.0, f"mode {n}") for n in range(500)]
    assert report.render([record]).count("<li><i") < 20


def test_no_line_ends_between_a_number_and_its_unit():
    glued = report.unbroken("at most 2 m/s, 1.5 m/s², 95 %, seed 1, figures from 120 s to 200 s, 3 landings")
    assert glued.replace("\N{NO-BREAK SPACE}", "~") == (
        "at most 2~m/s, 1.5~m/s², 95~%, seed 1, figures from 120~s to 200~s, 3 landings"
    )


def test_no_line_ends_within_an_option_of_a_command(made_up_bag):
    (record,) = analysis.analyse([made_up_bag()])
    record.notes = ["use a longer --duration or a shorter all.transient"]
    assert 'a longer <span class="option">--duration</span> or' in report.render([record])


def test_a_run_that_ended_within_its_transient_shows_its_settled_innovations(made_up_bag):
    """The first innovations of a filter dwarf all others, and such a run's figures begin with them."""
    (record,) = analysis.analyse([made_up_bag()])
    time = arange(0.0, 60.0, 0.1)
    payout = Innovation("payout", time, zeros(time.size), where(time < 5.0, 1.0, 0.01))  # [m]
    short = replace(record, innovations=[payout], start=0.0, end=60.0, is_past_transient=False)
    reach = innovation_figure(short).layout["yaxis"]["range"][1]
    assert 2.0 < reach < 3.0, "two predicted standard deviations of 1 cm, and a margin"


def test_a_comparison_explains_the_grey_only_where_some_is_drawn(made_up_bag):
    (record,) = analysis.analyse([made_up_bag()])
    for start, is_drawn in ((0.0, False), (20.0, True)):
        records = [replace(record, start=start)] * 2
        assert ("Grey" in comparison_figures(records, ["a", "b"])[0].caption) == is_drawn


def test_a_limit_that_was_learnt_is_drawn_from_when_on_it_is_told(shared_bag):
    (record,) = analysis.analyse([shared_bag])
    (figure,) = [one for one in run_figures(record) if one.title.startswith("Winch speed")]
    assert "learnt" not in figure.caption
    told = "winch_controller: alarms: WINCH_MODEL_UPDATED (event): acceleration limit paying out {} m/s^2 (was 1.500)."
    record.alarms += [Interval(time, time + 1.0, told.format(limit), 1) for time, limit in ((40.0, 0.6), (20.0, 0.9))]
    (figure,) = [one for one in run_figures(record) if one.title.startswith("Winch speed")]
    assert "dotted: limits that the controller has identified" in figure.caption
    upper, lower = [trace for trace in figure.traces if trace["name"] == "acceleration limit, learnt"]
    assert upper["yaxis"] == lower["yaxis"] == "y2"
    assert upper["x"] == lower["x"] == pack(array([20.0, 40.0, 40.0, record.end]))
    assert upper["y"] == pack(array([0.9, 0.9, 0.6, 0.6]))
    assert lower["y"] == pack(-array([0.9, 0.9, 0.6, 0.6]))


def test_a_comparison_is_called_by_what_differs(shared_bag):
    one, other = analysis.analyse([shared_bag, shared_bag])
    one.parameters = {"winch_controller": {"law": "off"}}
    other.parameters = {"winch_controller": {"law": "mpc"}}
    assert differences.title([one, other]) == "made_up: law: off / mpc"
    assert differences.labels([one, other]) == ["off", "mpc"]
    page = report.page_content([one, other], figures := [])
    assert [trace["name"] for trace in figures[0].traces] == ["off", "mpc"]
    assert len({run["colour"] for run in page["runs"]}) == 2
    other.parameters = {"winch_controller": {"law": "off", "sea.peak_period": 8.0}, "wave_vessel": {"peak_period": 8.0}}
    assert differences.labels([one, other]) == ["peak period - s", "peak period 8 s"], "the ship and the belief: once"


def test_what_happened_is_told_in_words_and_in_order(shared_bag):
    (record,) = analysis.analyse([shared_bag])
    modes = [("standby", ""), ("compensating", ""), ("stopping", "mru frozen"), ("stopped", "mru frozen")]
    record.modes = [Interval(10.0 * n, 10.0 * n + 10.0, mode, reason=reason) for n, (mode, reason) in enumerate(modes)]
    record.requests = [Interval(12.0, 12.0, "factor 0.8")]
    texts = [one.text for one in run_words.happenings(record)]
    assert "operator: factor 0.8" in texts
    assert "COMPENSATION_LOST (high): mode stopping: mru frozen" in texts
    assert run_words.losses(record) == ["t = 20.00 s: COMPENSATION_LOST (high): mode stopping: mru frozen"]
    times = [one.start for one in run_words.happenings(record)]
    assert times == sorted(times)
    assert any(re.fullmatch(r"winch at its speed limit for 2\.\d s", text) for text in texts)


def test_an_alarm_that_comes_again_and_again_is_one_line(shared_bag):
    (record,) = analysis.analyse([shared_bag])
    record.alarms = [
        Interval(5.0 * n, 5.0 * n + 1.0, f"SENSOR_LOST, DEPTH: no data for 0.{n} s. {loop}.", 1)
        for n, loop in enumerate(4 * ["Compensation continues"] + 3 * ["No compensation"], 1)
    ]
    record.alarms += [Interval(12.0, 13.0, "SENSOR_LOST, MRU: no data for 0.31 s", 2)] * 2
    found = [one for one in run_words.happenings(record) if "no data" in one.text]
    assert [(one.start, one.end, one.text, one.level) for one in found] == [
        (5.0, 36.0, "7 times, first: SENSOR_LOST, DEPTH: no data for 0.1 s. Compensation continues.", 1),
        (12.0, 13.0, "SENSOR_LOST, MRU: no data for 0.31 s", 2),
        (12.0, 13.0, "SENSOR_LOST, MRU: no data for 0.31 s", 2),
    ]


def test_the_errors_of_a_run_are_its_critical_and_high_alarms_the_gravest_first(shared_bag):
    """The end of a run left out high alarms of the controller, and listed a medium one since its sensor was lost."""
    (record,) = analysis.analyse([shared_bag])
    part = "winch_controller: alarms: "
    rows = (
        (10.0, 12.0, f"{part}SENSOR_LOST, DEPTH (medium): no data.", 1),
        (20.0, 20.0, f"{part}LOAD_SWINGS (high): the load swings.", 2),
        (30.0, 40.0, f"{part}DRUM_NOT_HELD (critical): drum turns.", 2),
        (15.0, 18.0, "WINCH_COMMAND_TIMEOUT", 2),
    )
    record.alarms = [Interval(*row) for row in rows]
    assert run_words.errors(record) == [
        "30.0 s to 40.0 s: DRUM_NOT_HELD (critical): drum turns.",
        "15.0 s to 18.0 s: WINCH_COMMAND_TIMEOUT",
        "20.0 s: LOAD_SWINGS (high): the load swings.",
    ]
    record.modes.append(Interval(50.0, 60.0, "emergency_stop", reason="emergency stop requested"))
    assert run_words.errors(record)[0] == "50.0 s: mode emergency_stop: emergency stop requested"


def test_a_list_that_is_empty_or_not_stated_is_no_difference(shared_bag):
    one, other = analysis.analyse([shared_bag, shared_bag])
    one.parameters = {"winch_controller": {"programme.modes": [], "law": "off"}}
    other.parameters = {"winch_controller": {"law": "mpc"}}
    assert [found.name for found in differences.differences([one, other])] == ["law"]


def test_scheduled_faults_are_one_difference_in_words(shared_bag):
    one, other = analysis.analyse([shared_bag, shared_bag])
    names = ("kind", "start", "duration", "magnitude")
    lists = (["freeze", "scale"], [180.0, 320.0], [20.0, 0.0], [0.0, -1.0])
    one.parameters = {"wave_vessel": {f"mru.faults.{name}": [] for name in names}}
    other.parameters = {
        "wave_vessel": {f"mru.faults.{name}": values for name, values in zip(names, lists, strict=True)}
    }
    assert [str(found) for found in differences.differences([one, other])] == [
        "mru faults: - / freeze from 180 s for 20 s, scale -1 from 320 s"
    ]
    assert differences.labels([one, other]) == [
        "no mru faults",
        "mru faults freeze from 180 s for 20 s, scale -1 from 320 s",
    ]
    other.parameters = {"wave_vessel": {"mru.faults.kind": 3, "mru.faults.start": ["never"]}}
    assert differences.differences([one, other]) == [], "a bag may state anything"


def test_the_report_of_one_run_shows_its_changes_and_faults_as_the_comparison_does(shared_bag):
    other, record = analysis.analyse([shared_bag, shared_bag])
    names = ("kind", "start", "duration", "magnitude")
    lists = (["low_pressure", "gap", "creep"], [15.0, 30.0, 900.0], [10.0, 0.0, 0.0], [0.15, 0.0, 0.1])
    faults = {f"faults.{name}": values for name, values in zip(names, lists, strict=True)}
    other.parameters = {"virtual_winch": {**{name: [] for name in faults}, "speed_limit": 2.0, "drive": "servo"}}
    record.parameters = {"virtual_winch": {**faults, "speed_limit": 0.5, "drive": "servo"}}
    record.run = {"changed": "virtual_winch.faults.kind, system.winch.speed_limit"}
    other.run = {}
    of_comparison = [one.of(1) for one in differences.differences([other, record])]
    facts = run_words.facts(record)
    assert facts["changed"] == "speed limit 0.5"
    assert facts["faults"] == "low_pressure 0.15 from 15 s for 10 s, gap from 30 s, creep 0.1 from 900 s"
    assert of_comparison == [f"faults {facts['faults']}", facts["changed"]]
    assert "changed" not in run_words.facts(other)
    assert [(one.when, one.text) for one in run_words.happenings(record) if "fault" in one.text] == [
        ("15.0 s to 25.0 s", "injected fault of the winch: low pressure, 0.15"),
        (f"30.0 s to {record.end:.1f} s", "injected fault of the winch: gap"),
    ]
    page = report.render([record])
    assert "<dt>changed</dt>" in page
    assert "<dt>faults</dt>" in page


def test_a_bag_names_the_parameters_that_were_changed_for_its_run(tmp_path):
    stored = b"# What it is.\n# All values.\n# changed: system.winch.speed_limit, wave_vessel.period\n"
    write_run(tmp_path / "changed", scenario=stored + SCENARIO.lstrip())
    (record,) = analysis.analyse([tmp_path / "changed"])
    assert run_words.facts(record)["changed"] == "period 8; speed limit 2"
    assert record.description == "What it is."


def test_a_report_states_the_load_in_air_in_water_and_at_the_hook(shared_bag):
    """Thesis 6.2.6: 50 kN in water, 54 N/m of cable in water, 900 m of it: 98.6 kN."""
    (record,) = analysis.analyse([shared_bag])
    rope = {"cable.diameter": 0.047, "cable.displaced_diameter": 0.045868, "cable.mass_per_length": 7.2}
    record.parameters = {"cable_sim": {"unit.mass": 65000.0, "unit.volume": 58.4404, "length": 900.0, **rope}}
    assert run_words.facts(record)["load"] == "65 t in air, 5.1 t in water, hook load 10.1 t"


def test_a_recorded_sea_is_named_by_its_file(shared_bag):
    (record,) = analysis.analyse([shared_bag])
    for file, words in (("/data/sea.csv", "recorded: sea.csv"), ("", "recorded")):
        record.parameters = {"wave_vessel": {"boom_tip_source": "file", "recording_file": file}}
        assert run_words.facts(record)["sea"] == words


@pytest.mark.parametrize("reason", ["stop requested", "standby requested"])
def test_what_somebody_has_asked_for_is_no_loss(shared_bag, reason):
    (record,) = analysis.analyse([shared_bag])
    record.modes = [Interval(0.0, 10.0, "compensating"), Interval(10.0, 20.0, "fade_out", reason=reason)]
    assert run_words.losses(record) == []


def test_a_run_with_little_in_it_still_gets_a_report(made_up_bag):
    (record,) = analysis.analyse([made_up_bag(run=MadeUpRun(duration=2.0))])
    assert "ended before its figures start to count" in report.render([record])


def test_the_transmissibility_is_scaled_to_where_the_boom_tip_moves(shared_bag):
    (record,) = analysis.analyse([shared_bag])
    time = arange(0.0, 600.0, 0.05)
    ratios = {0.6: (1.0, 1.2), 2.0: (0.02, 8.0), 3.5: (0.5, 60.0)}  # boom tip's amplitude, and the unit's over it
    tip, unit = (sum(a * r**n * sin(w * time) for w, (a, r) in ratios.items()) for n in (0, 1))
    record.start, record.end = 0.0, 600.0
    record.signals.boom_tip_heave = Signal(time, tip)
    record.signals.unit_heave = record.signals.uncompensated_heave = Signal(time, unit)
    figure = next(figure for figure in run_figures(record) if figure.title.startswith("Spectra"))
    bottom, top = figure.layout["yaxis2"]["range"]
    assert bottom == 0.0
    assert 1.2 < top < 2.0  # neither 8, where the boom tip hardly moves, nor 60, which is beyond the right edge


def test_no_limit_of_tension_lies_on_the_frame(shared_bag):
    (record,) = analysis.analyse([shared_bag])
    record.signals.static_tension = Signal(record.signals.tension.time[:1], record.signals.tension.value[:1])
    figure = next(figure for figure in run_figures(record) if figure.title == "Top tension")
    bottom, top = figure.layout["yaxis"]["range"]
    levels = [shape["y0"] for shape in figure.layout["shapes"] if shape["type"] == "line"]
    assert len(levels) == 4  # slack, 0.1, 1 and 1.3 static
    clearance = 0.05 * (top - bottom)
    assert bottom + clearance < min(levels)
    assert max(levels) < top - clearance


def test_thinning_keeps_every_peak():
    value = zeros(1_000_001)
    value[123_457], value[987_654] = 9.0, -7.0
    small = thin(Signal(arange(value.size) * 0.05, value), limit=2000)
    assert small.size <= 2000
    assert (small.value.max(), small.value.min()) == (9.0, -7.0)
    assert small.time[small.value.argmax()] == pytest.approx(123_457 * 0.05)


def test_even_times_travel_as_three_numbers_and_others_as_they_are():
    assert set(pack(0.05 * arange(1, 1000))) == {"start", "step", "count"}
    assert "float32" in pack(sin(arange(100.0)))


@browser.NEEDED
def test_the_report_fits_a_wide_screen_a_telephone_the_dark_and_paper(made_up_bag, tmp_path):
    report.save_report(analysis.analyse([made_up_bag()]), tmp_path / "report.html")
    width = "document.documentElement.scrollWidth"
    page = "getComputedStyle(document.body).backgroundColor"
    drawn = "document.querySelector('.figure .main-svg').style.background"
    buttons = "document.querySelectorAll('.modebar-btn').length"
    tops = "new Set([...r.getClientRects()].map(b => b.top)).size"
    lines = f"(r => (r.selectNodeContents(e), {tops}))(document.createRange())"
    broken = f"[...document.querySelectorAll('td.number, td.unit')].filter(e => {lines} > 1).map(e => e.innerText)"
    beside = "[...document.querySelectorAll('.figure .annotation')]"
    cut = f"{beside}.filter(e => right(e) > right(e.closest('.figure'))).length"
    cut = f"(right => {cut})(e => e.getBoundingClientRect().right)"
    named = "document.querySelectorAll('.figure')[0].querySelectorAll('.annotation').length"
    with browser.Browser(tmp_path / "browser") as chromium:
        tab = chromium.tab()
        tab.size(1400, 1000)
        tab.open((tmp_path / "report.html").as_uri())
        tab.wait("document.body && document.body.dataset.ready === 'true'")
        assert tab.get(width) <= 1400
        assert tab.get(named) == 3, "names stand beside the traces"
        assert tab.get(cut) == 0, "and inside the frame"
        assert tab.get("document.querySelector('.figure').getBoundingClientRect().bottom") < 1150, (
            "on the first screen, below the drawing"
        )
        tab.size(420, 900)
        tab.wait(f"{named} === 0")
        assert tab.get(width) <= 420
        assert tab.get(buttons) == 0, "nothing covers the names above the traces"
        assert tab.get(broken) == [], "no number and no unit is broken into two lines"
        tab("Emulation.setEmulatedMedia", media="", features=[{"name": "prefers-color-scheme", "value": "dark"}])
        tab.wait(f"{page} === 'rgb(18, 24, 30)'")
        tab.wait(f"{drawn} === 'rgb(18, 24, 30)'")
        tab("Emulation.setEmulatedMedia", media="print")
        tab.get("window.dispatchEvent(new Event('beforeprint'))")
        tab.wait(f"{drawn} === 'rgb(255, 255, 255)'")
        assert tab.get(page) == "rgb(255, 255, 255)"
        paper = (210.0 - 2 * 12.0) / 25.4 * 96.0 / 0.68  # A4 between margins of 12 mm, at the zoom of the style sheet
        drawn_width = "[...document.querySelectorAll('.figure')].map(f => Number(f.querySelector('svg').clientWidth))"
        assert all(0.97 * paper < found <= paper for found in tab.get(drawn_width)), "whole, whatever the window was"
        assert tab.get(named) == 3
        tab.get("window.dispatchEvent(new Event('afterprint'))")
        tab("Emulation.setEmulatedMedia", media="")
        tab.wait(f"{width} <= 420")
        assert tab.complaints == []


PROBE = """
<script>
const watch = setInterval(() => {
  if (document.body.dataset.ready !== "true") return;
  clearInterval(watch);
  const [first, second] = document.querySelectorAll(".figure");
  const dense = () => second.data[0].x.filter((x) => x >= 20 && x <= 21).length;
  Plotly.relayout(first, { "xaxis.range[0]": 20, "xaxis.range[1]": 21 }).then(() => setTimeout(() => {
    document.body.dataset.zoom = second.layout.xaxis.range.map((x) => x.toFixed(1)).join(" ") + " " + dense();
  }, 1500));
}, 100);
</script>
</body>"""


@browser.NEEDED
def test_figures_over_time_zoom_together_down_to_every_sample(made_up_bag, tmp_path):
    page = tmp_path / "report.html"
    bag = made_up_bag(run=MadeUpRun(duration=400.0))  # 8,000 samples, of which a screen shows 3,000
    report.save_report(analysis.analyse([bag]), page)
    probe = report.security_policy([re.search("<script>(.*)</script>", PROBE, re.DOTALL).group(1)])
    allowed = re.search("script-src ('sha256-[^']+')", probe).group(1)
    text = page.read_text().replace("script-src ", f"script-src {allowed} ", 1)
    page.write_text(text.replace("</body>", PROBE))
    drawn, console = browse(page, tmp_path)
    assert console == []
    assert re.search(r'data-zoom="20\.0 21\.0 (\d+)"', drawn).group(1) in ("20", "21")  # one second at 20 Hz


@browser.NEEDED
def test_a_report_becomes_a_pdf_of_some_pages(made_up_bag, tmp_path):
    report.save_report(analysis.analyse([made_up_bag()]), tmp_path / "report.html")
    paper.save_pdf(tmp_path / "report.html", tmp_path / "report.pdf")
    content = (tmp_path / "report.pdf").read_bytes()
    assert 3 <= content.count(b"/Type /Page\n") <= 12
    boxes = set(re.findall(rb"/MediaBox \[([^\]]*)\]", content))
    assert [[round(float(side)) for side in box.split()] for box in boxes] == [[0, 0, 595, 842]], "A4 in points"


def test_a_machine_without_a_browser_says_what_to_do(monkeypatch, tmp_path):
    monkeypatch.setattr(paper, "PLACES", ())
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(BagError, match=r"no Chromium, Chrome or Edge is installed here.*open report\.html"):
        paper.save_pdf(tmp_path / "report.html", tmp_path / "report.pdf")


def test_a_browser_that_writes_nothing_is_named(monkeypatch, tmp_path):
    (tmp_path / "chromium").write_text("#!/bin/sh\necho no display >&2; exit 1\n")
    (tmp_path / "chromium").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin:/usr/bin")
    (tmp_path / "report.pdf").write_text("an older one")
    with pytest.raises(BagError, match="wrote nothing: no display"):
        paper.save_pdf(tmp_path / "report.html", tmp_path / "report.pdf")
    assert not (tmp_path / "report.pdf").exists(), "an older one is not taken for it"
