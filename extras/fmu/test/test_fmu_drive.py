"""A drive given as an FMU: names of its own by a map, what is missing filled in, what is wrong refused in a line."""

import math
import re
import subprocess
import sys
import zipfile

import pytest
from cable_sim_node.winch.command_line import WinchCommand
from heave_bringup import ClosedLoop, load_scenario, loop_parameters
from heave_bringup.errors import CommandError, ExitStatus
from heave_fmu import archive
from heave_fmu.archive import unpack_fmu
from heave_node.parameters import ParameterError

pytest.importorskip("pythonfmu", reason="pythonfmu is not installed: the extra fmu")
pytest.importorskip("fmpy", reason="fmpy is not installed: the extra fmu")

from fmpy import platform, sharedLibraryExtension
from heave_fmu.drive import DriveMap, FmuWinch, drive_names, read_drive
from heave_fmu.instance import FmuInstance

LAG = 0.4
STRANGER = f'''
import math
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Stranger(Fmi2Slave):
    """A drum behind a lag of first order; knows only a speed reference in and a position out."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.v_ref = self.x = self.v = 0.0
        self.lag = {LAG}
        self.register_variable(Real("v_ref", causality=Fmi2Causality.input))
        self.register_variable(Real("lag", causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))
        self.register_variable(Real("x", causality=Fmi2Causality.output))

    def do_step(self, time, step):
        left = math.exp(-step / self.lag)
        self.x += self.v_ref * step + (self.v - self.v_ref) * self.lag * (1.0 - left)
        self.v = self.v_ref + (self.v - self.v_ref) * left
        return self.v_ref < 100.0
'''
NAMES = {"winch.command.payout_rate": "v_ref", "winch.state.payout": "x"}


def fmu_of(folder, variables, code="m"):
    """Write an FMU that has `variables`, "name type causality" each, and code of a name that cannot run."""
    rows = "".join(
        f'<ScalarVariable name="{name}" valueReference="{number}" causality="{causality}" '
        f'variability="{"tunable" if causality == "parameter" else "discrete"}"><{kind}/></ScalarVariable>'
        for number, (name, kind, causality) in enumerate(one.split() for one in variables.split(", "))
    )
    file = folder / "made.fmu"
    with zipfile.ZipFile(file, "w") as made:
        made.writestr(
            "modelDescription.xml",
            '<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g">'
            f'<CoSimulation modelIdentifier="{code}"/><ModelVariables>{rows}</ModelVariables>'
            "<ModelStructure/></fmiModelDescription>",
        )
        made.writestr(f"binaries/{platform}/m{sharedLibraryExtension}", "no code")
    return file


@pytest.fixture
def stranger(tmp_path, request):
    # a class of its own for each test: PythonFMU reads one only once in a process
    name = "Stranger" + "".join(part.capitalize() for part in re.findall("[a-z]+", request.node.name))[-60:]
    script = tmp_path / f"{name.lower()}.py"
    script.write_text(STRANGER.replace("class Stranger", f"class {name}"))
    build = [sys.executable, "-m", "pythonfmu", "build", "-f", str(script), "-d", str(tmp_path)]
    subprocess.run(build, check=True, capture_output=True)
    return tmp_path / f"{name}.fmu"


def stepped(winch, ticks, rate=1.0):
    state = None
    for tick in range(1, ticks + 1):
        state = winch.step(tick, WinchCommand(tick, 0.0, rate, False), 1000.0)
    return state._asdict()


def test_a_drive_with_names_of_its_own_follows_its_lag_and_the_rest_is_filled_in(stranger):
    winch = FmuWinch(DriveMap(stranger, NAMES, {"lag": 0.8}), tick_period=0.05)
    state = stepped(winch, 40)
    # u(t) = t - T (1 - exp(-t/T)) for a step of 1 m/s, T = 0.8 s, t = 2 s
    assert state["payout"] == pytest.approx(2.0 - 0.8 * (1.0 - math.exp(-2.5)), abs=1e-12)
    assert state["encoder_payout"] == state["payout"]
    # its difference over a tick, by the rate between: 1 - exp(-t/T) in the middle of the tick
    assert state["encoder_payout_rate"] == pytest.approx(1.0 - math.exp(-(2.0 - 0.025) / 0.8), abs=1e-3)
    assert math.isnan(state["payout_acceleration"])
    assert (state["command_sequence"], state["brake"], state["fault"]) == (40, False, 0)
    assert state["power"] == pytest.approx(-1000.0 * state["payout_rate"])
    with pytest.raises(CommandError, match="DoStep"):
        winch.step(41, WinchCommand(41, 0.0, 200.0), None)


def with_units(file, units, definitions, step=None):
    """Write a copy of an FMU with `units` of its variables, by `definitions`, and a fixed `step` [s]; return it."""
    changed = file.with_name("units.fmu")
    with zipfile.ZipFile(file) as source, zipfile.ZipFile(changed, "w") as target:
        for name in source.namelist():
            content = source.read(name)
            if name == "modelDescription.xml":
                text = re.sub(r"<UnitDefinitions.*?</UnitDefinitions>", "", content.decode(), flags=re.DOTALL)
                for variable, unit in units.items():
                    text = re.sub(rf'(name="{variable}"[^>]*>\s*<Real)', rf'\1 unit="{unit}"', text)
                text = re.sub(r"(<CoSimulation[^>]*/>)", rf"\1<UnitDefinitions>{definitions}</UnitDefinitions>", text)
                if step is not None:
                    text = re.sub(r'canHandleVariableCommunicationStepSize="\w+"', "", text)
                    text = text.replace("<ModelVariables>", f'<DefaultExperiment stepSize="{step}"/><ModelVariables>')
                content = text.encode()
            target.writestr(name, content)
    return changed


MILLIMETRES = (
    '<Unit name="mm/s"><BaseUnit m="1" s="-1" factor="0.001"/></Unit>'
    '<Unit name="mm"><BaseUnit m="1" factor="0.001"/></Unit>'
)


def test_declared_units_and_the_scale_of_a_map_are_converted(stranger):
    """A drive in mm/s and mm that hauls in: 1 m/s for 2 s is 1.6 m by its lag of 0.4 s (v t - v T), in any unit."""
    file = with_units(stranger, {"v_ref": "mm/s", "x": "mm"}, MILLIMETRES)
    scales = {"winch.command.payout_rate": -1.0, "winch.state.payout": -1.0}
    plain = stepped(FmuWinch(DriveMap(stranger, NAMES), tick_period=0.05), 40)
    winch = FmuWinch(DriveMap(file, NAMES, scales=scales), tick_period=0.05)
    assert winch._fmu.get("v_ref") == 0.0
    state = stepped(winch, 40, rate=0.05)
    assert state["encoder_payout"] == pytest.approx(0.05 * plain["encoder_payout"])
    assert winch._fmu.get("v_ref") == pytest.approx(-50.0), "hauling in, in mm/s"
    winch.close()


@pytest.mark.parametrize(
    ("unit", "definitions", "words"),
    [
        ("mm/s2", '<Unit name="mm/s2"><BaseUnit m="1" s="-2" factor="0.001"/></Unit>', "not of one kind"),
        ("zero", '<Unit name="zero"><BaseUnit m="1" s="-1" factor="0"/></Unit>', "convert nothing"),
        ("furlong", "", "does not define"),
        ("mm", "", "does not define"),
    ],
)
def test_a_unit_that_cannot_be_converted_is_refused_with_both(stranger, unit, definitions, words):
    file = with_units(stranger, {"v_ref": unit}, definitions)
    with pytest.raises(CommandError, match=rf"v_ref is in {unit}.*m/s.*|{words}") as refused:
        drive_names(DriveMap(file, NAMES))
    assert words in str(refused.value)


def test_a_fixed_step_is_kept_within_a_tick_and_one_that_does_not_fit_is_refused(stranger):
    file = with_units(stranger, {}, "", step=0.01)
    winch = FmuWinch(DriveMap(file, NAMES), tick_period=0.05)
    assert winch._fmu.steps_in(0.05) == 5
    assert stepped(winch, 40)["encoder_payout"] > 1.0
    winch.close()
    file = with_units(stranger, {}, "", step=0.02)
    with pytest.raises(CommandError, match=r"takes steps of 0\.02 s alone, and a tick is 0\.05 s"):
        FmuWinch(DriveMap(file, NAMES), tick_period=0.05)


def test_a_drive_that_lacks_what_a_drive_must_have_is_refused(stranger):
    with pytest.raises(CommandError, match=r"needs the variable winch\.command\.payout_rate or winch\.command\.payout"):
        FmuWinch(DriveMap(stranger), tick_period=0.05)


@pytest.mark.parametrize(
    ("variables", "start", "words"),
    [
        ({"winch.state.brake": "y"}, {}, "variables: winch.state.brake: y is no variable of it"),
        ({"winch.command.payout_rate": "on"}, {}, "payout_rate: on is Boolean, and the message has Real"),
        ({"winch.state.payout": "v_ref"}, {}, "winch.state.payout: v_ref is an input"),
        ({"winch.state.limits_hit": "x"}, {}, "limits_hit: x is Real, and the message has Integer"),
        ({}, {"lagg": 0.5}, "start: lagg is no variable of it"),
        ({}, {"lag": "fast"}, "start: lag is Real, and takes no 'fast'"),
        ({}, {"lag": math.nan}, "start: lag is Real, and takes no nan"),
        ({}, {"lag": True}, "start: lag is Real, and takes no True"),
        ({}, {"on": 1}, "start: on is Boolean, and takes no 1"),
    ],
)
def test_a_map_that_the_fmu_does_not_fit_is_refused_by_name_before_its_code_runs(tmp_path, variables, start, words):
    file = fmu_of(tmp_path, "v_ref Real input, lag Real parameter, x Real output, on Boolean input")
    with pytest.raises(CommandError, match=re.escape(words)) as refused:
        drive_names(DriveMap(file, {**NAMES, **variables}, start))
    assert refused.value.status is ExitStatus.REFUSED
    assert str(refused.value).startswith(f"{file}: ")


def test_a_flag_is_read_from_any_number_and_an_integer_goes_into_a_real(tmp_path):
    file = fmu_of(tmp_path, "v_ref Real input, x Real output, held Real output, number Real input")
    names = {**NAMES, "winch.state.brake": "held", "winch.command.sequence": "number"}
    assert {name: own.name for name, own in drive_names(DriveMap(file, names)).items()} == names


def test_an_fmu_without_code_for_this_system_is_refused(tmp_path):
    with pytest.raises(CommandError, match=r"no code for this system, binaries/.*/other\."):
        drive_names(DriveMap(fmu_of(tmp_path, "v_ref Real input, x Real output", code="other"), NAMES))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("fmu: other.fmu", "no such file"),
        ("variables: {}", "must hold `fmu: FILE`"),
        ("fmu: drive.fmu\nspeed: 1", "must hold `fmu: FILE`"),
        ("fmu: drive.fmu\nvariables: {winch.state.colour: x}", "winch.state.colour: must be one of"),
        ("fmu: drive.fmu\nstart: 3", "must be names"),
        ("fmu: &a [*a]", "aliases"),
    ],
)
def test_a_map_that_is_wrong_is_refused_in_one_line(tmp_path, text, words):
    (tmp_path / "drive.fmu").write_bytes(b"")
    path = tmp_path / "drive.yaml"
    path.write_text(text)
    with pytest.raises(ParameterError, match=re.escape(words)) as refused:
        read_drive(path)
    assert "\n" not in str(refused.value)


def test_a_map_names_the_fmu_beside_it(tmp_path):
    (tmp_path / "drive.fmu").write_bytes(b"")
    path = tmp_path / "drive.yaml"
    path.write_text("fmu: drive.fmu\nvariables: {winch.state.payout: x}\nstart: {lag: 0.5}\n")
    assert read_drive(path) == DriveMap(tmp_path / "drive.fmu", {"winch.state.payout": "x"}, {"lag": 0.5})
    for wrong in (tmp_path / "none.fmu", tmp_path):
        with pytest.raises(ParameterError):
            read_drive(wrong)


@pytest.mark.parametrize("name", ["../evil", "/etc/evil", "a/../../evil", "a\\evil", "x" * 300])
def test_a_name_that_leads_out_of_the_folder_is_refused_and_nothing_is_written(tmp_path, name):
    file, folder = tmp_path / "bad.fmu", tmp_path / "inside" / "folder"
    folder.mkdir(parents=True)
    with zipfile.ZipFile(file, "w") as made:
        made.writestr("modelDescription.xml", "<fmiModelDescription/>")
        made.writestr(name, "evil")
    with pytest.raises(CommandError, match=r"bad\.fmu: no FMU that can be used: .* no name of a file"):
        unpack_fmu(file, folder)
    assert not list(folder.iterdir())


def test_an_fmu_that_is_too_large_or_no_archive_is_refused(tmp_path, monkeypatch):
    file = tmp_path / "bad.fmu"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as made:
        made.writestr("modelDescription.xml", "0" * 100_000)
    monkeypatch.setattr(archive, "LARGEST_FMU", 99_999)
    with pytest.raises(CommandError, match="more than"):
        unpack_fmu(file, tmp_path)
    file.write_bytes(file.read_bytes()[:50])
    with pytest.raises(CommandError, match="no FMU that can be used"):
        FmuInstance(file, "winch")


def test_an_fmu_of_another_kind_is_refused(tmp_path):
    file = tmp_path / "other.fmu"
    head = '<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><ModelExchange modelIdentifier="m"/>'
    with zipfile.ZipFile(file, "w") as made:
        made.writestr("modelDescription.xml", f"{head}<ModelVariables/><ModelStructure/></fmiModelDescription>")
    with pytest.raises(CommandError, match="must be an FMU for co-simulation"):
        FmuInstance(file, "winch")


FOLLOWER = f'''
import math
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Follower(Fmi2Slave):
    """A drum with a position loop, thesis Eq. 6.1: u' = (u_0 - u)/T."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.x_ref = self.x = self.v = 0.0
        self.register_variable(Real("x_ref", causality=Fmi2Causality.input))
        self.register_variable(Real("x", causality=Fmi2Causality.output))

    def do_step(self, time, step):
        self.x = self.x_ref + (self.x - self.x_ref) * math.exp(-step / {LAG})
        return True
'''


@pytest.mark.slow
def test_a_drive_with_a_position_loop_compensates_in_the_whole_loop_as_one_that_goes_by_rate(stranger, tmp_path):
    """The stranger's lag of the speed is the follower's of the position: by linearity both move alike."""
    (tmp_path / "follower.py").write_text(FOLLOWER)
    build = [sys.executable, "-m", "pythonfmu", "build", "-f", str(tmp_path / "follower.py"), "-d", str(tmp_path)]
    subprocess.run(build, check=True, capture_output=True)
    by_payout = {"winch.command.payout": "x_ref", "winch.state.payout": "x"}
    settings = [f"winch_controller.winch.time_constant={LAG}", "winch_controller.winch.command_delay=0.0"]
    settings += ["winch_controller.law=lqg", "all.duration=180"]
    residuals = []
    for file, names in ((stranger, NAMES), (tmp_path / "Follower.fmu", by_payout)):
        closed = ClosedLoop(loop_parameters(load_scenario("b2_calm_300", settings=settings)))
        drive = FmuWinch(DriveMap(file, names), tick_period=0.05)

        def step(tick, command, tension, winch=closed.winch, drive=drive):
            winch.state = drive.step(tick, command, tension)
            return winch.state

        closed.winch.step = step
        record = closed.run()
        residuals.append(record.unit_sigma(after=90.0))
        assert residuals[-1] < 0.05 * record.uncompensated_sigma(after=90.0)
    assert residuals[1] == pytest.approx(residuals[0], rel=0.1)
