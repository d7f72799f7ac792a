"""The controller without Python does what the nodes' does, tick by tick, and closes the loop with the same figures."""

import math
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from heave_bags.analyse import kpi_set
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.errors import CommandError
from heave_bringup.run.loop_signals import run_signals
from heave_bringup.scenarios import load_scenario

pytest.importorskip("pythonfmu", reason="pythonfmu is not installed: the extra fmu")
fmpy = pytest.importorskip("fmpy", reason="fmpy is not installed: the extra fmu")

from heave_fmu.compiled.build import MODEL, compile_sources, export_controller, write_sources  # noqa: E402
from heave_fmu.compiled.image import leave_out_plans, records_of  # noqa: E402
from heave_fmu.export import connections, export_part, make_parts, write_system  # noqa: E402
from heave_fmu.instance import FmuInstance  # noqa: E402

AGREEMENT = 1e-9
"""Largest difference of a number, relative and absolute: they are the same bits where compilers are the same."""
LQG = ("winch_controller.law=lqg",)
SETTINGS = (*LQG, "winch_controller.entry.accept_unproved=true")
"""An operator consents to compensation without a cross-check: numbers that are no sea have none."""
GAP = (
    *("wave_vessel.mru.faults.kind=[gap]", "wave_vessel.mru.faults.start=[40.0]"),
    *("wave_vessel.mru.faults.duration=[6.0]", "wave_vessel.mru.faults.magnitude=[0.0]"),
)
"""The MRU is silent for some seconds."""
PREVIEW = ("wave_vessel.preview.time=4", "winch_controller.law=mpc", "winch_controller.mpc.preview_time=3")
LOOPS = Path(__file__).parent / "fmu_loops.py"


def both(scenario, file, seconds):
    """Return mode, brake and numbers of the part and of the FMU in a `file`, with the readings of the part's loop."""
    parts = make_parts(scenario, ("controller", "winch", "vessel", "plant"))
    places = {
        (name, variable.name): (port.values, index)
        for name, part in parts.items()
        for port in (*part.inputs.values(), *part.outputs.values())
        for index, variable in enumerate(port.variables)
    }
    wires = [(*places[source, name], *places[target, name]) for name, source, target in connections(parts)]
    for part in parts.values():
        part.start()
    controller = parts["controller"]
    leave_out_plans(controller._controller)
    controller._controller.take = lambda beliefs: False  # an adviser that is absent
    instance, dt, rows = FmuInstance(file, "controller"), scenario.run.tick_period, []
    names = [variable.name for port in controller.outputs.values() for variable in port.variables]
    for tick in range(1, round(seconds / dt) + 1):
        for part in parts.values():
            for source, index, target, own in wires:
                target[own] = source[index]
            if part is controller:
                for port in part.inputs.values():
                    for variable, value in zip(port.variables, port.values, strict=True):
                        instance.set(variable.name, value)
                instance.step((tick - 1) * dt, dt)
            part.step(tick)
            if part is controller:
                rows.append(
                    [
                        (places["controller", name][0][places["controller", name][1]], instance.get(name))
                        for name in names
                    ]
                )
    instance.close()
    return names, rows


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("b2_calm_300", settings=["all.duration=40", "all.transient=30", *SETTINGS])


@pytest.fixture(scope="module")
def folder(scenario, tmp_path_factory):
    made = tmp_path_factory.mktemp("fmus")
    for part in ("controller", "winch", "vessel", "plant"):
        export_part(scenario, part, made, "c")
    write_system(scenario, made)
    return made


def assert_same(scenario, file, seconds, modes):
    names, rows = both(scenario, file, seconds)
    assert modes <= {row[names.index("controller.state.mode")][0] for row in rows}
    for place, output in enumerate(names):
        wanted, found = zip(*(row[place] for row in rows), strict=True)
        if isinstance(wanted[0], str):
            assert found == wanted
        else:
            given = np.array(found, float), np.array(wanted, float)
            np.testing.assert_allclose(*given, AGREEMENT, AGREEMENT, err_msg=output)


def test_it_does_what_the_node_does_in_each_tick_also_where_a_sensor_is_lost(folder):
    scenario = load_scenario("b2_calm_300", settings=[*SETTINGS, *GAP])
    assert_same(scenario, folder / "controller.fmu", 60, {"standby", "compensating", "fade_out"})


@pytest.mark.slow
@pytest.mark.parametrize(("name", "settings"), [("b2_calm_300", ()), ("b1_thesis", LQG)])
def test_it_does_so_with_a_law_that_plans_and_with_a_winch_that_goes_by_its_place(tmp_path, name, settings):
    scenario = load_scenario(name, settings=settings)
    assert_same(scenario, export_controller(scenario, tmp_path), 40, {"standby", "compensating"})


def figures_of(record, scenario):
    signals = run_signals(record, loop_parameters(scenario))
    return kpi_set.evaluate_run(signals, scenario.run.transient, scenario.run.duration)


@pytest.mark.slow
@pytest.mark.parametrize("master", ["fmpy", "libcosimpy"])
def test_closed_by_a_master_it_gives_the_figures_of_the_loop(scenario, folder, tmp_path, master):
    pytest.importorskip(master, reason=f"{master} is not installed: the extra fmu")
    file = tmp_path / "rows.npz"
    times = [str(scenario.run.tick_period), str(scenario.run.duration)]
    subprocess.run([sys.executable, str(LOOPS), master, str(folder), str(file), *times], check=True, timeout=500)
    with np.load(file) as found:
        record = LoopRecord(found["rows"], found["modes"].tolist())
    wanted = figures_of(ClosedLoop(loop_parameters(scenario), has_adviser=False).run(), scenario)
    figures, known = figures_of(record, scenario), {name for name, value in wanted.items() if math.isfinite(value)}
    assert len(known) > 40
    assert wanted["unit_efficiency"] > 0.5
    for name in known:
        assert figures[name] == pytest.approx(wanted[name], rel=AGREEMENT, abs=AGREEMENT), name


def test_it_begins_again_the_same_and_takes_a_fourth_of_a_tick(folder):
    instance = FmuInstance(folder / "controller.fmu", "controller")

    def rates(steps):
        found = []
        for tick in range(1, 601):
            time, payout = tick * 0.05, 0.05 * sum(found[:-5])  # of a drum that follows late
            instance.set("unit.pressure.count", 0)
            instance.set("winch.load_cell.count", 0)
            instance.set("mru.heave", 0.3 * math.sin(0.9 * time))
            instance.set("mru.heave_rate", 0.27 * math.cos(0.9 * time))
            instance.set("winch.state.encoder_payout", payout)
            instance.set("winch.state.command_sequence", max(tick - 3, 0))
            for step in range(steps):
                instance.step((tick - 1 + step / steps) * 0.05, 0.05 / steps)
            found.append(instance.get("winch.command.payout_rate"))
        return found

    once = rates(1)
    instance.restart()
    assert rates(4) == once
    assert np.std(once) > 0.01
    instance.close()


def test_the_file_is_valid_says_what_is_left_out_and_holds_no_python(folder, tmp_path):
    file = folder / "controller.fmu"
    from fmpy.validation import validate_fmu  # noqa: PLC0415

    assert validate_fmu(str(file)) == []
    description = fmpy.read_model_description(str(file))
    assert "No adviser" in description.description
    assert {variable.name: variable.unit for variable in description.modelVariables}["mru.heave_rate"] == "m/s"
    with zipfile.ZipFile(file) as archive:
        names = set(archive.namelist())
        archive.extractall(tmp_path)
    assert {
        f"sources/{name}" for name in ("controller.cpp", "supervise.cpp", "envelope.cpp", "fmu.c", "image.h")
    } < names
    assert not [name for name in names if name.endswith((".py", ".yaml"))]
    library = tmp_path / "binaries" / "linux64" / f"{MODEL}.so"
    wanted = subprocess.run(["nm", "-D", "-u", library], check=True, capture_output=True, text=True).stdout
    # no Python, and no memory but what the caller gives for an instance
    assert "exp" in wanted
    assert not [line for line in wanted.splitlines() if "alloc" in line or " Py" in line or "dlopen" in line]


def test_sanitizers_find_nothing(scenario, tmp_path):
    write_sources(make_parts(scenario, ["controller"])["controller"], tmp_path / "sources")
    (tmp_path / "sources" / "main.c").write_text((Path(__file__).parent / "fmu_sanitized.c").read_text())
    flags = ("-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    try:
        compile_sources(tmp_path / "sources", tmp_path / "sanitized", *flags)
    except CommandError as error:
        if "sanitize" in str(error) or "asan" in str(error):
            pytest.skip("the compiler has no sanitizers")
        raise
    environment = {name: value for name, value in os.environ.items() if name != "LD_PRELOAD"}
    done = subprocess.run([tmp_path / "sanitized"], check=False, capture_output=True, text=True, env=environment)
    assert (done.returncode, done.stderr) == (0, "")
    assert abs(float(done.stdout)) > 0.0


@pytest.mark.parametrize(
    ("scenario_name", "settings", "words"),
    [
        ("b2_calm_300", PREVIEW, "uses a preview of the sea: --set winch_controller.law=lqg"),
        ("b7_landing", (), "nobody makes them there"),
        ("crane_slew", (), "a crane that moves stands in front"),
    ],
)
def test_it_refuses_what_it_would_not_be(tmp_path, scenario_name, settings, words):
    with pytest.raises(CommandError, match=words):
        export_controller(load_scenario(scenario_name, settings=settings), tmp_path)


def test_commands_that_are_late_by_the_limit_and_no_more_are_tried_there_too(scenario):
    controller = ClosedLoop(loop_parameters(scenario)).controller
    assert controller.parameters.lag.largest == 0.3
    late = 6 * 0.05  # ticks, with a rounding error
    assert 0.3 < late <= float(records_of(controller)["active"]["tolerated_delay"][0]) < 0.301


@pytest.mark.parametrize(("variable", "kind"), [("CC", "C"), ("CXX", r"C\+\+")])
def test_a_compiler_that_is_not_there_is_named(scenario, tmp_path, monkeypatch, variable, kind):
    monkeypatch.setenv(variable, "no_such_compiler")
    with pytest.raises(CommandError, match=f"no_such_compiler: No such file or directory; {variable} names a {kind} "):
        export_controller(scenario, tmp_path)
