"""A law of somebody else is selected by its place or by an entry point, without a change of the suite."""

import os
import subprocess
import sys
from dataclasses import replace

import pytest
from heave_node.parameters import ParameterError, build_parameters
from winch_controller_node.core.component import WinchController
from winch_controller_node.design.wire import parameters_of, parameters_text
from winch_controller_node.interface.readings import Measurements
from winch_controller_node.laws import registry
from winch_controller_node.laws.registry import LAWS, LOADED, law_class, load_law
from winch_controller_node.node_parameters import WinchControllerParameters, load_chosen_parts

LAW = """
from dataclasses import dataclass
from heave_node.parameters import parameter
from winch_controller_node.laws.law import ControlLaw, LawCommand

@dataclass(frozen=True)
class Own:
    gain: float = parameter(1.0, unit="", minimum=0.0, maximum=2.0, description="Share of the boom tip's rate.")

class Half(ControlLaw):
    name = "half"
    summary = "a share of the boom tip's rate"
    parameters_type = Own
    required_sensors = ("mru",)
    feeds_back_unit = False

    def __init__(self, design, parameters):
        super().__init__(design, parameters)
        self.row = parameters.gain * design.model.row("boom_tip_heave_rate")

    def command(self, state):
        return LawCommand(float(self.row @ state.x))

number = 3
class Nameless(ControlLaw):
    summary = "has no name"
    def command(self, state):
        return LawCommand(0.0)
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A working folder with a law in it; what is loaded does not stay."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(LOADED, "")
    monkeypatch.setattr(registry, "LAWS", dict(LAWS))
    (tmp_path / "halves.py").write_text(LAW)
    yield tmp_path
    sys.modules.pop("halves", None)


def controller(law: str, *given: str) -> WinchController:
    values = {"law": law, "law_parameters": list(given)}
    parameters = build_parameters(WinchControllerParameters, values, where="here")
    load_chosen_parts(parameters)
    return WinchController(parameters, tick_period=0.05)


@pytest.mark.parametrize("place", ["halves.py:Half", "halves:Half"])
def test_a_law_in_the_working_folder_drives_the_controller_with_its_own_parameters(here, place):
    made = controller(place, "gain=0.5")
    design = made.design
    assert design.make_law().row.tolist() == (0.5 * design.model.row("boom_tip_heave_rate")).tolist()
    assert made.step(1, Measurements()).report.mode == "standby"


def test_a_process_that_was_started_afterwards_may_load_the_same_law(here, monkeypatch):
    load_law("halves.py:Half")
    assert os.environ[LOADED] == "halves.py:Half"
    monkeypatch.setattr(registry, "LAWS", dict(LAWS))
    assert law_class("halves.py:Half").name == "half"


def test_a_place_in_a_message_loads_nothing(here):
    """The adviser gets the controller's parameters in a message that any process of the domain could send."""
    (here / "harm.py").write_text("import pathlib; pathlib.Path('harm').touch()")
    sent = parameters_text(replace(WinchControllerParameters(), law="harm.py:Law"))
    parameters = parameters_of(sent)
    with pytest.raises(ParameterError, match=r"harm\.py:Law: is not loaded in this process; start it with HEAVE_LAWS="):
        law_class(parameters.law)
    assert not (here / "harm").exists()


@pytest.mark.parametrize(
    ("law", "given", "words"),
    [
        ("none.py:Half", (), "law none.py:Half: no such file: none.py"),
        ("no.such:Half", (), "law no.such:Half: there is no module no.such, installed or in"),
        ("halves:Quarter", (), "law halves:Quarter: halves has no Quarter"),
        ("halves:number", (), "is not a class derived from winch_controller_node.laws.law.ControlLaw"),
        ("halves:Nameless", (), "law halves:Nameless: has no name"),
        ("halves:Half", ("gain=3",), "law_parameters of law half: gain = 3.0 is not allowed"),
        ("halves:Half", ("gian=1",), "there is no parameter gian; did you mean gain?"),
        ("halves:Half", ("gain",), "law_parameters: 'gain' must be NAME=VALUE"),
        ("half", (), "or MODULE:CLASS or FILE.py:CLASS of a law of your own"),
        ("broken.py:Half", (), "law broken.py:Half: ZeroDivisionError: division by zero"),
    ],
)
def test_what_is_no_law_is_refused_in_one_line(here, law, given, words):
    (here / "broken.py").write_text("1 / 0")
    with pytest.raises(ParameterError) as refused:
        controller(law, *given)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_an_installed_package_brings_laws_with_their_groups_and_one_that_is_broken_harms_no_other(here):
    names = {"half": "halves:Half", "gone": "nowhere:Law"}
    info = here / "halves-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: halves\nVersion: 1\n")
    (info / "entry_points.txt").write_text("[heave.laws]\n" + "".join(f"{a} = {b}\n" for a, b in names.items()))
    program = (
        "from heave_node.parameters import build_parameters\n"
        "from winch_controller_node.node_parameters import WinchControllerParameters as P\n"
        "p = build_parameters(P, {'law': 'half', 'half.gain': 0.5}, where='here')\n"
        "print(p.law, p.half.gain)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(here)}
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=False, timeout=120
    )
    assert done.stdout == "half 0.5\n", done.stderr
    assert "heave: warning: ModuleNotFoundError: No module named 'nowhere'" in done.stderr
