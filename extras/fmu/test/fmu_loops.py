"""Close exported FMUs by FMPy or libcosim: `fmu_loops.py fmpy|libcosimpy FOLDER ROWS.npz TICK_PERIOD DURATION`."""

import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from heave_bringup.closed_loop import COLUMNS
from heave_fmu.instance import FmuInstance
from heave_fmu.part import STEPS

ORDER = ("controller", "winch", "vessel", "plant")

SOURCES = {
    "boom_tip": ("vessel", "boom_tip.position.z"),
    "unit": ("plant", "unit.odometry.pose.pose.position.z"),
    "uncompensated": ("plant", "unit_uncompensated.position.z"),
    "payout": ("winch", "winch.state.payout"),
    "payout_rate": ("winch", "winch.state.payout_rate"),
    "payout_acceleration": ("winch", "winch.state.payout_acceleration"),
    "top_tension": ("plant", "cable.state.top_tension"),
    "largest_top_tension": ("plant", "cable.state.largest_top_tension"),
    "authority": ("controller", "controller.state.authority"),
    "depth_set_point": ("controller", "controller.state.depth_set_point"),
    "touchdown_force": ("plant", "cable.state.touchdown_force"),
    "unit_rate": ("plant", "unit.odometry.twist.twist.linear.z"),
    "uncompensated_tension": ("plant", "unit_uncompensated.cable.top_tension"),
    "uncompensated_largest_tension": ("plant", "unit_uncompensated.cable.largest_top_tension"),
    "slack_segments": ("plant", "cable.state.slack_segments"),
    "limits_hit": ("winch", "winch.state.limits_hit"),
    "unit_tension": ("plant", "cable.state.bottom_tension"),
}
MODE = ("controller", "controller.state.mode")


def by_fmpy(folder, dt, ticks):
    """Step each part once a tick, in the order of the loop."""
    instances = {part: FmuInstance(folder / f"{part}.fmu", part) for part in ORDER}
    wires = list(wires_of(folder))

    def value(place):
        return instances[place[0]].get(place[1])

    for tick in range(1, ticks + 1):
        for part in ORDER:
            for source, target in wires:
                if target[0] == part:
                    instances[part].set(target[1], value(source))
            instances[part].step((tick - 1) * dt, dt)
            if part == "controller":
                yield value
    for instance in instances.values():
        instance.close()


def wires_of(folder):
    """Yield what goes where, by the system that was written for libcosim."""
    for wire in ElementTree.parse(folder / "OspSystemStructure.xml").getroot().iter():
        if wire.tag.endswith("VariableConnection"):
            source, target = wire
            yield tuple((end.get("simulator"), end.get("name")) for end in (source, target))


def by_libcosim(folder, dt, ticks):
    """Let libcosim step all parts together, STEPS times a tick."""
    from libcosimpy.CosimEnums import CosimVariableType  # noqa: PLC0415 - an extra
    from libcosimpy.CosimExecution import CosimExecution  # noqa: PLC0415 - an extra
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level  # noqa: PLC0415 - an extra
    from libcosimpy.CosimObserver import CosimObserver  # noqa: PLC0415 - an extra

    log_output_level(CosimLogLevel.ERROR)
    execution, observer = CosimExecution.from_osp_config_file(str(folder)), CosimObserver.create_last_value()
    execution.add_observer(observer)
    places = {
        (info.name.decode(), variable.name.decode()): (info.index, variable.reference, CosimVariableType(variable.type))
        for info in execution.slave_infos()
        for variable in execution.slave_variables(info.index)
    }
    read = {
        CosimVariableType.REAL: observer.last_real_values,
        CosimVariableType.INTEGER: observer.last_integer_values,
        CosimVariableType.STRING: observer.last_string_values,
    }

    def value(place):
        index, reference, kind = places[place]
        (found,) = read[kind](index, [reference])
        return found.decode() if isinstance(found, bytes) else found

    for _ in range(ticks):
        assert execution.step(1)
        yield value
        assert execution.step(STEPS - 1)


def main(master, folder, file, dt, duration):
    ticks = round(float(duration) / float(dt))
    loop = {"fmpy": by_fmpy, "libcosimpy": by_libcosim}[master](Path(folder), float(dt), ticks)
    rows, modes = [], []
    for tick, value in enumerate(loop, start=1):
        rows.append([tick * float(dt) if name == "time" else value(SOURCES[name]) for name in COLUMNS])
        modes.append(value(MODE))
    np.savez(file, rows=np.array(rows, dtype=float), modes=np.array(modes))


if __name__ == "__main__":
    main(*sys.argv[1:])
