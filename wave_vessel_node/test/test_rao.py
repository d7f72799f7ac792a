import math
import os

import numpy as np
import pytest
from heave_node.numerics.constants import STANDARD_GRAVITY
from wave_vessel_node.parameters import CourseParameters
from wave_vessel_node.sea.realisation import WaveComponents
from wave_vessel_node.sea.spectra import Bretschneider
from wave_vessel_node.sources.rao_components import RaoSource
from wave_vessel_node.vessel.fit import VesselOnCourse, fit_vessel
from wave_vessel_node.vessel.motion import VesselMotions, lever_arm_matrix, point_motions
from wave_vessel_node.vessel.rao import RaoError, ResponseTable, between, encounter_frequency
from wave_vessel_node.vessel.rao_files import (
    COLUMNS,
    read_rao,
    read_rao_csv,
    shipped_rao,
    write_rao_csv,
)
from wave_vessel_node.vessel.second_order import SecondOrderVessel

HEAVE, ROLL, PITCH = 2, 3, 4
OMEGA = np.linspace(0.2, 2.0, 10)


def flat_table(value=1.0, headings=(0.0, np.pi / 2, np.pi), speeds=(0.0,)):
    response = np.full((len(speeds), len(headings), 6, OMEGA.size), value, dtype=complex)
    response[:, :, [1, 3, 5]] = 0.0
    return ResponseTable(np.array(speeds), np.array(headings), OMEGA, response)


def one_wave(omega, direction=0.0, amplitude=1.0, phase=0.0):
    return WaveComponents(np.array([omega]), np.array([amplitude]), np.array([phase]), np.array([direction]))


def test_long_waves_carry_the_shipped_hull_with_them():
    # limit of zero frequency: heave follows the surface, pitch and roll its slope k
    table = shipped_rao()
    omega = table.frequency[0]
    slope = omega**2 / STANDARD_GRAVITY
    head = table.at([omega], np.pi, 0.0)[:, 0]
    beam = table.at([omega], np.pi / 2, 0.0)[:, 0]
    assert head[HEAVE] == pytest.approx(1.0, abs=2e-3)
    # head sea: the slope along the waves' travel is bow-down pitch, -i k; heading pi turns the sign with the bow
    assert head[PITCH] == pytest.approx(-1j * slope, rel=0.03)
    assert beam[HEAVE] == pytest.approx(1.0, abs=2e-3)
    assert abs(beam[ROLL]) == pytest.approx(slope, rel=0.1)


def test_short_waves_leave_the_shipped_hull_still_and_beam_seas_move_it_most():
    table = shipped_rao()
    assert np.abs(table.at([2.5], np.pi, 0.0)).max() < 5e-3
    omega = np.array([0.8])
    assert abs(table.at(omega, np.pi / 2)[HEAVE, 0]) > 3.0 * abs(table.at(omega, np.pi)[HEAVE, 0])
    assert np.abs(table.at(table.frequency, np.pi)[[1, 3, 5]]).max() < 1e-3


def test_a_symmetric_ship_answers_waves_from_both_sides_alike():
    table = shipped_rao()
    omega = np.linspace(0.3, 2.0, 7)
    port, starboard = table.at(omega, 1.1), table.at(omega, 2 * np.pi - 1.1)
    np.testing.assert_allclose(
        starboard, port * np.array([1, -1, 1, -1, 1, -1])[:, None], atol=1e-6
    )  # headings in the file have 6 decimals


def test_the_table_is_met_at_its_own_points():
    table = shipped_rao()
    for s, h, f in ((0, 3, 10), (2, 7, 25), (1, 12, 5)):
        value = table.at([table.frequency[f]], table.heading[h], table.speed[s])[:, 0]
        np.testing.assert_allclose(value, table.response[s, h, :, f], atol=2e-5)


def test_speed_between_two_tables_is_linear():
    response = np.concatenate((flat_table(1.0).response, flat_table(3.0).response))
    table = ResponseTable(np.array([0.0, 4.0]), np.array([0.0, np.pi / 2, np.pi]), OMEGA, response)
    assert table.at([1.0], 0.5, 1.0)[HEAVE, 0] == pytest.approx(1.5)
    assert table.at([1.0], 0.5, 9.0)[HEAVE, 0] == pytest.approx(3.0)


def test_encounter_frequency_rises_in_head_seas_and_vanishes_where_waves_are_as_fast_as_the_ship():
    speed = 5.0
    assert encounter_frequency(1.0, np.pi, speed) == pytest.approx(1.0 + 5.0 / STANDARD_GRAVITY)
    assert encounter_frequency(1.0, np.pi / 2, speed) == pytest.approx(1.0)
    assert encounter_frequency(STANDARD_GRAVITY / speed, 0.0, speed) == pytest.approx(0.0, abs=1e-12)


def test_a_ship_under_way_meets_the_waves_at_the_encounter_frequency():
    course = CourseParameters(speed=4.0)
    source = RaoSource(one_wave(0.9, direction=np.pi), flat_table(speeds=(0.0, 8.0)), course, np.zeros(3), 0.05)
    expected = 0.9 + 0.9**2 / STANDARD_GRAVITY * 4.0
    for tick in (1, 100, 5000):
        motions = source.motions(range(tick, tick + 1))
        heave, rate, _ = motions.six[0, :, HEAVE]
        assert heave == pytest.approx(math.cos(expected * tick * 0.05), abs=1e-9)
        assert rate == pytest.approx(-expected * math.sin(expected * tick * 0.05), abs=1e-9)
        assert motions.elevation[0] == pytest.approx(heave, abs=1e-9)


def test_the_elevation_is_taken_below_the_boom_tip():
    arm = np.array([20.0, 0.0, 10.0])
    source = RaoSource(one_wave(0.9), flat_table(), CourseParameters(), arm, 0.05)
    expected = math.cos(0.9 * 0.05 - 0.9**2 / STANDARD_GRAVITY * 20.0)
    assert source.motions(range(1, 2)).elevation[0] == pytest.approx(expected, abs=1e-12)


def test_the_boom_tip_moves_as_a_rigid_body():
    # heave - x pitch + y roll, and the horizontal parts, against the rotation matrix of a small turn
    arm = np.array([-20.0, 10.0, 15.0])
    q = np.array([0.3, -0.2, 0.5, 1e-6, -2e-6, 3e-6])
    roll, pitch, yaw = q[3:]
    skew = np.array([[0, -yaw, pitch], [yaw, 0, -roll], [-pitch, roll, 0]])
    expected = q[:3] + skew @ arm
    np.testing.assert_allclose(lever_arm_matrix(arm) @ q, expected, atol=1e-15)
    heave = (lever_arm_matrix(arm) @ q)[2]
    assert heave == pytest.approx(0.5 + 20.0 * pitch + 10.0 * roll, abs=1e-12)


def test_heading_turns_the_horizontal_motion_into_the_world():
    motions = VesselMotions.still(range(1, 2), 0.05)
    motions.heading, motions.six[0, 0, 0] = math.pi / 2, 2.0
    points = point_motions(motions, lever_arm_matrix(np.zeros(3)), 5.0)
    np.testing.assert_allclose(points[0, 0], [0.0, 2.0, 5.0], atol=1e-12)


def test_a_table_written_is_read_back(tmp_path):
    table = shipped_rao()
    write_rao_csv(tmp_path / "t.csv", table, comments=["a copy"])
    again = read_rao_csv(tmp_path / "t.csv")
    np.testing.assert_allclose(again.response, table.response, atol=2e-4)


def csv_text(rows, columns=COLUMNS):
    return "\n".join([",".join(columns), *(",".join(str(value) for value in row) for row in rows)]) + "\n"


def rows_of(headings=(0.0, 1.6, 3.14159), omegas=(0.2, 0.5, 1.0, 2.0)):
    return [[0.0, heading, omega] + [1.0, 0.0] * 6 for heading in headings for omega in omegas]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (csv_text(rows_of(), COLUMNS[:-1]), "missing columns yaw_phase_rad"),
        (csv_text(rows_of()[:-1]), "omega_radps 2 is missing"),
        (csv_text([*rows_of(), rows_of()[0]]), "repeated"),
        (
            csv_text(rows_of()).replace("3.14159,0.2,1.0", "3.14159,0.2,x1"),
            "line 10: surge_m_per_m: 'x1' is not a number",
        ),
        (csv_text(rows_of()).replace("3.14159,0.2,1.0", "3.14159,0.2,nan"), "not a finite number"),
        (csv_text(rows_of()).replace("3.14159,0.2,1.0", "3.14159,0.2,-1.0"), "amplitude is negative"),
        (csv_text(rows_of(headings=(0.0, 1.0))), "headings must span"),
        (
            csv_text(rows_of(headings=(0.0, 90.0, 180.0))),
            "from 0 to below 2 pi rad, they are 0 to 180: are they in deg",
        ),
        (csv_text(rows_of(headings=(0.0, 3.0, 6.2832))), "they are 0 to 6.2832: 2 pi is the same as 0"),
        (csv_text(rows_of()).replace("_", "-"), "line 1: expected the header speed_mps,heading_rad"),
        (csv_text(rows_of(headings=(0.0, 4.0, 5.0))), "headings leave 4 rad of the circle out after 0"),
        (csv_text(rows_of(omegas=(0.5, 1.0))), "expected at least 4 frequencies"),
        ("", "is empty"),
        (csv_text(rows_of())[:-20], "line 13: 11 values where the header has 15"),
    ],
)
def test_a_table_that_cannot_be_used_is_refused_in_one_line(tmp_path, text, says):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(RaoError, match=says) as error:
        read_rao(path)
    assert "bad.csv" in str(error.value)
    assert "\n" not in str(error.value)


def test_files_that_are_missing_or_of_another_kind_are_refused(tmp_path):
    with pytest.raises(RaoError, match="no such file"):
        read_rao(tmp_path / "none.csv")
    (tmp_path / "x.txt").write_text("")
    with pytest.raises(RaoError, match=r"\(\.csv\)"):
        read_rao(tmp_path / "x.txt")


def test_a_fit_gives_a_second_order_vessel_back():
    omega = np.linspace(0.2, 3.0, 60)
    true = SecondOrderVessel(0.9, 0.4, 1.1)
    fit = fit_vessel(omega, true.response(omega), Bretschneider(2.0, 8.0))
    assert (fit.vessel.natural_frequency, fit.vessel.damping_ratio, fit.vessel.gain) == pytest.approx((0.9, 0.4, 1.1))
    assert fit.relative_error < 1e-6


def boom_tip_heave_response(table, omega, heading, speed, arm):
    """Return the heave of a point, `arm` from the reference point, per wave amplitude, by the whole table."""
    return lever_arm_matrix(arm)[2] @ table.at(omega, np.full(omega.shape, heading), speed)


def test_a_fit_without_energy_is_refused():
    with pytest.raises(RaoError, match="where the sea has energy"):
        fit_vessel(np.linspace(0.2, 2.0, 20), np.zeros(20), Bretschneider(2.0, 8.0))


def test_a_vessel_on_its_course_is_the_table_at_its_heading_and_reads_its_file_once(tmp_path, monkeypatch):
    path, arm, omega = tmp_path / "own.csv", (-20.0, 10.0, 15.0), np.linspace(0.1, 6.0, 300)
    write_rao_csv(path, shipped_rao())
    read = []
    monkeypatch.setattr(
        "wave_vessel_node.vessel.fit.read_rao", lambda *arguments: read.append(arguments) or read_rao(*arguments)
    )
    vessel = VesselOnCourse(str(path), arm, 2.5, 0.0)
    first, again = vessel.response(omega), vessel.response(omega)
    expected = boom_tip_heave_response(read_rao(path), omega, 2.5, 0.0, np.array(arm))
    # between frequencies at one heading here, at each heading of the table there
    np.testing.assert_allclose(first, expected, atol=2e-3)
    np.testing.assert_array_equal(first, again)
    assert len(read) == 1
    os.utime(path, (1, 1))  # another file in its place
    vessel.response(omega)
    assert len(read) == 2
    knots = shipped_rao().frequency
    at_knots = boom_tip_heave_response(read_rao(path), knots, 2.5, 1.0, np.array(arm))
    np.testing.assert_allclose(VesselOnCourse(str(path), arm, 2.5, 1.0).response(knots), at_knots, atol=1e-12)


def plausible_rows(heave=1.0, roll=0.02, phase=0.5, omegas=(0.2, 0.5, 1.0, 2.0)):
    """Rows of a ship with one heave and one roll at all headings and frequencies."""
    motions = [0.3, 0.0, 0.2, 0.0, heave, phase, roll, 0.0, 0.01, -1.5, 0.0, 0.0]
    return [[0.0, heading, omega, *motions] for heading in (0.0, 1.6, 3.14159) for omega in omegas]


def as_excel(text):
    return "\ufeff" + text.replace(",", ";").replace(".", ",")


@pytest.mark.parametrize(
    "form",
    [
        lambda text: text.encode("utf-8-sig"),
        lambda text: text.encode("utf-16"),
        lambda text: as_excel(text).encode(),
        lambda text: text.replace(",", "\t").encode(),
        lambda text: text.replace(",", "  ").encode(),
        lambda text: ("# hull of M\xfcller\n" + text).encode("latin-1"),
        lambda text: ("My ship,at zero speed\n" + text.replace("\n", "\r\n")).encode(),
    ],
)
def test_a_table_is_read_in_whatever_form_a_tool_saves_it(tmp_path, form):
    (tmp_path / "plain.csv").write_text(csv_text(plausible_rows()))
    (tmp_path / "saved.csv").write_bytes(form(csv_text(plausible_rows())))
    plain, saved = read_rao(tmp_path / "plain.csv"), read_rao(tmp_path / "saved.csv")
    assert plain.warnings == ()
    np.testing.assert_array_equal(saved.response, plain.response)


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (plausible_rows(heave=1029.0), "heave in long waves is 1029 m/m, .*: millimetres or centimetres"),
        (plausible_rows(heave=100.0), "centimetres"),
        (plausible_rows(heave=0.0), "heave in long waves is 0 m/m, .*: columns exchanged"),
        (plausible_rows(roll=5.7), r"roll response is 5\.7 rad/m, .*: degrees"),
        (plausible_rows(phase=-158.0), "line 2: heave_phase_rad: phase is -158 rad, .*: degrees"),
        (plausible_rows(omegas=(0.03, 0.1, 0.2, 0.32)), r"highest wave frequency is 0\.32 rad/s, .*: hertz"),
        (plausible_rows(omegas=(4.0, 8.0, 12.0, 25.0)), "lowest wave frequency is 4 rad/s, .*: periods"),
    ],
)
def test_responses_that_cannot_be_are_refused_unless_they_are_accepted(tmp_path, rows, says):
    (tmp_path / "ship.csv").write_text(csv_text(rows))
    with pytest.raises(RaoError, match=says) as refused:
        read_rao(tmp_path / "ship.csv")
    assert "ship.csv" in str(refused.value)
    assert "--set system.accept_implausible=true takes" in str(refused.value)
    assert "\n" not in str(refused.value)
    accepted = read_rao(tmp_path / "ship.csv", accept_implausible=True)
    assert any(says.split()[0] in warning for warning in accepted.warnings)


@pytest.mark.parametrize("lever", [0.0, 40.0, -80.0])
def test_between_coarse_frequencies_the_amplitude_is_kept_whatever_the_phase_does(lever):
    """F = A(w) exp(i w^2 x / g) of a body at x: known between the frequencies, where A passes through zero too."""
    omega, fine = np.arange(0.2, 1.81, 0.1), np.arange(0.2, 1.8, 0.01)

    def response(w):
        return np.cos(1.5 * w) * np.exp(-0.5 * w**2) * np.exp(1j * w**2 * lever / STANDARD_GRAVITY)

    found, known = between(omega, response(omega), fine), response(fine)
    assert np.abs(found - known).max() < 0.01 * np.abs(known).max()


@pytest.mark.parametrize("forward", [0.0, 60.0, -60.0])
def test_a_table_of_a_reference_point_far_from_the_waves_origin_holds_between_its_frequencies(forward):
    """The shipped hull, seen from `forward` metres along the waves: each phase turns by k x, no amplitude does."""
    table = shipped_rao()
    coarse = table.frequency
    turn = np.exp(1j * coarse**2 / STANDARD_GRAVITY * forward)
    moved = ResponseTable(table.speed, table.heading, coarse, table.response * turn)
    plain = ResponseTable(table.speed, table.heading, coarse, table.response)
    omega = np.linspace(coarse[0], coarse[-1], 300)
    for heading in (np.pi, 2.0):
        expected = plain.at(omega, heading) * np.exp(1j * omega**2 / STANDARD_GRAVITY * forward)
        found = moved.at(omega, heading)
        largest = np.abs(expected).max(axis=1, keepdims=True)
        assert (np.abs(found - expected) / np.maximum(largest, 1e-2)).max() < 0.02
