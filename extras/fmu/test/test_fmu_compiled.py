"""The fixed controller in C does what its reference of filter, law and governor objects does, and closes the loop."""

import math
import os
import runpy
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from heave_bags.analyse import kpi_set
from heave_bringup.closed_loop import COLUMNS, LoopRecord, loop_parameters
from heave_bringup.errors import CommandError
from heave_bringup.run.loop_signals import run_signals
from heave_bringup.scenarios import load_scenario

pytest.importorskip("pythonfmu", reason="pythonfmu is not installed: the extra fmu")
fmpy = pytest.importorskip("fmpy", reason="fmpy is not installed: the extra fmu")

from heave_fmu.compiled.build import MODEL, compile_sources, export_controller, write_sources  # noqa: E402
from heave_fmu.compiled.part import FixedControllerPart  # noqa: E402
from heave_fmu.export import connections, export_part, make_parts, write_system  # noqa: E402
from heave_fmu.instance import FmuInstance  # noqa: E402

AGREEMENT = 1e-10
"""Largest difference from the reference over the rms: sums in another order, through a stable filter."""
KINDS = ("inputs", "outputs")
FIGURES = 1e-6
"""Largest difference of a figure, relative and absolute."""
LQG = ("winch_controller.law=lqg", "winch_controller.modes.settling_time=3", "winch_controller.modes.fade_in_time=4")
SERVO = (
    *("system.winch.position_gain=0.4", "winch_controller.winch.set_point_reach=1.3"),
    *("winch_controller.winch.creep=0.01", "winch_controller.winch.hauling_gain=0.9"),
)


def inputs_at(tick, dt, height, rng, payout):
    """Return what comes in a tick by name: a tip in long waves, a unit after it, readings late, wrong and missing.

    The drum's `payout` is where the orders have taken it, or the envelope would brake.
    """
    time = tick * dt
    heave, rate = height * math.sin(0.9 * time), 0.9 * height * math.cos(0.9 * time)
    given = {
        "mru.status": int(tick % 97 == 0),
        "mru.heave": heave + 0.01 * rng.standard_normal(),
        "mru.heave_rate": math.nan if tick % 13 == 0 else rate + 0.01 * rng.standard_normal(),
        "mru.header.stamp": time - 0.3 * dt,
        "winch.state.encoder_payout": payout + 3e-4 * rng.standard_normal(),
        "unit.pressure.fluid_pressure": 3.1e6 - 1e4 * heave + 200.0 * rng.standard_normal() + 2e5 * (tick % 71 == 0),
        "unit.pressure.header.stamp": time - (0.1 if tick % 50 else 2.0),
    }
    counts = {"mru.count": tick - tick // 31, "winch.state.count": -1, "unit.pressure.count": tick // 2}
    return given | counts


def places_of(ports):
    return {
        variable.name: (port.values, index) for port in ports.values() for index, variable in enumerate(port.variables)
    }


@pytest.mark.parametrize(
    ("scenario", "settings", "height"),
    [
        ("b2_calm_300", (), 0.3),
        ("b2_calm_300", SERVO, 2.5),
        ("b2_calm_300", ("winch_controller.law=lqr",), 1.0),
        ("b4_limit_900_tp10", (), 4.0),
    ],
)
def test_it_does_what_the_reference_does(tmp_path, scenario, settings, height):
    loaded = load_scenario(scenario, settings=[*LQG, *settings])
    part = FixedControllerPart(loop_parameters(loaded))
    part.start()
    instance = FmuInstance(export_controller(loaded, tmp_path), "controller")
    takes, gives = places_of(part.inputs), places_of(part.outputs)
    rng, dt, both = np.random.default_rng(5), part.tick_period, []
    for tick in range(1, 601):
        payout = float(part.envelope.state["drum"]["payout"][0])
        for name, value in inputs_at(tick, dt, height, rng, payout).items():
            values, index = takes[name]
            values[index] = value
            instance.set(name, value)
        part.step(tick)
        instance.step((tick - 1) * dt, dt)
        row = {name: (values[index], instance.get(name)) for name, (values, index) in gives.items()}
        both.append(row.pop("winch.command.payout_rate"))
        for name, (wanted, found) in row.items():
            assert found == (wanted if isinstance(wanted, str) else pytest.approx(float(wanted), rel=1e-9, abs=1e-9)), (
                name
            )
    instance.close()
    wanted, found = np.array(both).T
    assert row["controller.state.authority"][1] == 1.0
    assert part.envelope.state["cause"][0] == 0.0
    assert np.std(wanted) > 0.05
    assert np.max(np.abs(found - wanted)) < AGREEMENT * np.std(wanted)


def test_it_begins_again_the_same_and_takes_a_fourth_of_a_tick(tmp_path):
    instance = FmuInstance(export_controller(load_scenario("b2_calm_300", settings=LQG), tmp_path), "controller")

    def rates(steps):
        rng, found = np.random.default_rng(1), []
        for tick in range(1, 121):
            payout = 0.05 * sum(found[:-5])  # of a drum that follows late
            for name, value in inputs_at(tick, 0.05, 1.0, rng, payout).items():
                instance.set(name, value)
            for step in range(steps):
                instance.step((tick - 1 + step / steps) * 0.05, 0.05 / steps)
            found.append(instance.get("winch.command.payout_rate"))
        return found

    once = rates(1)
    instance.restart()
    assert rates(4) == once
    assert np.std(once) > 0.01
    instance.close()


def test_the_file_is_valid_says_what_is_left_out_and_holds_no_python(tmp_path):
    file = export_part(load_scenario("b2_calm_300", settings=LQG), "controller", tmp_path, "c")
    from fmpy.validation import validate_fmu  # noqa: PLC0415

    assert validate_fmu(str(file)) == []
    description = fmpy.read_model_description(str(file))
    assert "no supervision" in description.description
    assert {variable.name: variable.unit for variable in description.modelVariables}["mru.heave_rate"] == "m/s"
    with zipfile.ZipFile(file) as archive:
        names = set(archive.namelist())
        archive.extractall(tmp_path / "unpacked")
    assert {"sources/filter.c", "sources/controller.c", "sources/fmu.c", "sources/design.h"} < names
    assert {"sources/last_step.cpp", "sources/envelope.cpp", "sources/layout.h", "sources/bounds.h"} < names
    assert not [name for name in names if name.endswith((".py", ".yaml"))]
    library = tmp_path / "unpacked" / "binaries" / "linux64" / f"{MODEL}.so"
    wanted = subprocess.run(["nm", "-D", "-u", library], check=True, capture_output=True, text=True).stdout
    # no Python, and no memory but what the caller gives for an instance
    assert "exp" in wanted
    assert not [line for line in wanted.splitlines() if "alloc" in line or " Py" in line or "dlopen" in line]


def test_sanitizers_find_nothing(tmp_path):
    part = FixedControllerPart(loop_parameters(load_scenario("b2_calm_300", settings=LQG)))
    write_sources(part, tmp_path / "sources")
    (tmp_path / "sources" / "main.c").write_text((Path(__file__).parent / "fmu_sanitized.c").read_text())
    flags = ("-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
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
    ("scenario", "settings", "words"),
    [
        ("b2_calm_300", (), "law mpc is none: --set winch_controller.law=lqg"),
        ("b1_thesis", (), "for a speed servo"),
        ("b10_real_mru_swell", LQG, "estimates no scale and no lever arm"),
    ],
)
def test_it_refuses_what_it_would_not_be(tmp_path, scenario, settings, words):
    with pytest.raises(CommandError, match=words):
        export_controller(load_scenario(scenario, settings=settings), tmp_path)


@pytest.mark.parametrize(("variable", "kind"), [("CC", "C"), ("CXX", r"C\+\+")])
def test_a_compiler_that_is_not_there_is_named(tmp_path, monkeypatch, variable, kind):
    monkeypatch.setenv(variable, "no_such_compiler")
    with pytest.raises(CommandError, match=f"no_such_compiler: No such file or directory; {variable} names a {kind} "):
        export_controller(load_scenario("b2_calm_300", settings=LQG), tmp_path)


def test_a_drum_that_runs_is_braked_and_an_order_beyond_the_bounds_is_not_sent(tmp_path):
    """The count runs away: the last step is the envelope, in the reference and in the FMU alike."""
    loaded = load_scenario("b2_calm_300", settings=LQG)
    part = FixedControllerPart(loop_parameters(loaded))
    part.start()
    instance = FmuInstance(export_controller(loaded, tmp_path), "controller")
    takes, gives = places_of(part.inputs), places_of(part.outputs)
    rng, dt, brakes, runaway = np.random.default_rng(5), part.tick_period, [], 0.0
    for tick in range(1, 301):
        runaway += 0.02 if tick > 200 else 0.0
        payout = float(part.envelope.state["drum"]["payout"][0]) + runaway
        for name, value in inputs_at(tick, dt, 0.3, rng, payout).items():
            values, index = takes[name]
            values[index] = value
            instance.set(name, value)
        part.step(tick)
        instance.step((tick - 1) * dt, dt)
        values, index = gives["winch.command.brake"]
        assert bool(values[index]) == bool(instance.get("winch.command.brake"))
        brakes.append(bool(values[index]))
    instance.close()
    begun = brakes.index(False)
    assert begun < 200 < begun + brakes[begun:].index(True) < 220
    assert all(brakes[220:])


def loop_of_parts(scenario, sources, mode):
    """Return the record of the loop that the reference closes, columns from `sources` as `fmu_loops.py` has them."""
    parts = make_parts(scenario, ("controller", "winch", "vessel", "plant"), "c")
    places = {(name, kind): places_of(getattr(part, kind)) for name, part in parts.items() for kind in KINDS}
    wires = [
        (*places[source, "outputs"][name], *places[target, "inputs"][name])
        for name, source, target in connections(parts)
    ]
    for part in parts.values():
        part.start()
    rows, modes = [], []
    for tick in range(1, round(scenario.run.duration / scenario.run.tick_period) + 1):
        for name, part in parts.items():
            for source, index, target, own in wires:
                target[own] = source[index]
            part.step(tick)
            if name == "controller":
                found = {key: places[place[0], "outputs"][place[1]] for key, place in {**sources, "mode": mode}.items()}
                read = {key: values[index] for key, (values, index) in found.items()}
                rows.append([tick * scenario.run.tick_period if key == "time" else read[key] for key in COLUMNS])
                modes.append(read["mode"])
    return LoopRecord(np.array(rows, dtype=float), modes)


LOOPS = Path(__file__).parent / "fmu_loops.py"


@pytest.fixture(scope="module")
def closed(tmp_path_factory):
    """Return a scenario, a folder with its parts as FMUs, and the record of the loop that the reference closes."""
    scenario = load_scenario("b2_calm_300", settings=[*LQG, "all.duration=40", "all.transient=15"])
    folder = tmp_path_factory.mktemp("parts")
    for part in ("controller", "winch", "vessel", "plant"):
        export_part(scenario, part, folder, "c")
    write_system(scenario, folder, "c")
    stated = runpy.run_path(str(LOOPS))
    return scenario, folder, loop_of_parts(scenario, stated["SOURCES"], stated["MODE"])


@pytest.mark.slow
@pytest.mark.parametrize("master", ["fmpy", "libcosimpy"])
def test_closed_by_a_master_it_gives_the_figures_of_its_reference(closed, tmp_path, master):
    pytest.importorskip(master, reason=f"{master} is not installed: the extra fmu")
    (scenario, folder, reference), file = closed, tmp_path / "rows.npz"
    times = [str(scenario.run.tick_period), str(scenario.run.duration)]
    subprocess.run([sys.executable, str(LOOPS), master, str(folder), str(file), *times], check=True, timeout=500)
    with np.load(file) as found:
        record = LoopRecord(found["rows"], found["modes"].tolist())
    figures, wanted = (
        kpi_set.evaluate_run(run_signals(one, loop_parameters(scenario)), scenario.run.transient, scenario.run.duration)
        for one in (record, reference)
    )
    known = {name for name, value in wanted.items() if math.isfinite(value)}
    assert len(known) > 40
    assert wanted["unit_efficiency"] > 0.5
    for name in known:
        assert figures[name] == pytest.approx(wanted[name], rel=FIGURES, abs=FIGURES), name
