"""MoorDyn as a peer of the plant: the same system, driven the same way. Needs the package `moordyn`; not used in a run.

Its tangential drag is (1/2) rho d pi C, the thesis's form, so C_tau goes over unchanged; its one diameter is the
displaced one here, and the drag coefficients carry the ratio of the outer diameter to it.
"""

from __future__ import annotations

import contextlib
import math
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableSimParameters
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PointMotion

_SUBMERGENCE = 50.0
"""Depth by which everything is lowered [m], so that the moving top stays in the water as the plant's does."""


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Keep what native code prints to standard output away from it: MoorDyn reports every step there."""
    sys.stdout.flush()
    kept = os.dup(1)
    with Path(os.devnull).open("wb") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        try:
            yield
        finally:
            os.dup2(kept, 1)
            os.close(kept)


@dataclass(frozen=True)
class PeerRun:
    """A run of the peer."""

    times: Array  # [s], shape (k,)
    unit: Array  # positions of the unit relative to the top's mean [m], shape (k, 3)
    tension: Array  # in the line at its top end [N], shape (k,)
    cpu_per_second: float  # processor seconds per simulated second


@dataclass(frozen=True)
class Setting:
    """How MoorDyn integrates."""

    name: str  # for people
    scheme: str  # by MoorDyn's name
    order: int  # of the scheme, whose stages are as many
    damping: float  # of the line's fastest axial oscillation, a share of the critical one

    def stability_limit(self) -> float:
        """Return the largest h w at which an oscillation of frequency w does not grow with steps of h.

        The amplification of a step is the Taylor polynomial of e^z, z = h w (-zeta +- i sqrt(1 - zeta^2)).
        """
        root = complex(-self.damping, math.sqrt(1.0 - self.damping**2))
        size, step = 0.0, 1e-4
        while abs(sum((root * (size + step)) ** k / math.factorial(k) for k in range(self.order + 1))) <= 1.0 + 1e-9:
            size += step
        return size


RK4 = Setting("RK4", "RK4", order=4, damping=0.0)
RK2 = Setting("RK2, zeta 0.5", "RK2", order=2, damping=0.5)
SETTINGS = (RK2, RK4)
"""RK2 is the fastest, and needs damping to be stable; RK4 does without, as the plant does."""


def largest_stable_step(parameters: CableSimParameters, setting: Setting = RK4, safety: float = 0.85) -> float:
    """Return a step [s] just inside the stability limit of the line's fastest axial oscillation, w = 2 c/l.

    Parameters
    ----------
    parameters : of the plant
    setting : of MoorDyn
    safety : share of the limit
    """
    cable = parameters.cable
    speed = math.sqrt(cable.axial_stiffness / cable.mass_per_length)
    return safety * 0.5 * setting.stability_limit() * parameters.length / parameters.segments / speed


def input_file(parameters: CableSimParameters, unit_position: Array, setting: Setting, step: float) -> str:
    """Return the text of MoorDyn's input file for a unit on a uniform line in still water.

    Parameters
    ----------
    parameters : of the plant
    unit_position : at the start [m], shape (3,)
    setting : of MoorDyn
    step : of its time integration [s]
    """
    cable, unit = parameters.cable, parameters.unit
    diameter = cable.displaced_diameter or cable.diameter
    ratio = cable.diameter / diameter
    added = unit.added_mass[2] / (parameters.water_density * unit.volume)
    drag_area = unit.drag_coefficient[2] * unit.drag_area[2]
    x, y, z = unit_position
    return f"""unit on a line
---------------------- LINE TYPES ----------------------
TypeName   Diam     Mass/m     EA         BA/-zeta    EI         Cd     Ca     CdAx    CaAx
(name)     (m)      (kg/m)     (N)        (N-s/-)     (N-m^2)    (-)    (-)    (-)     (-)
line {diameter} {cable.mass_per_length} {cable.axial_stiffness} {-setting.damping} 0 \
{cable.normal_drag * ratio} {cable.added_mass} {cable.tangential_drag * ratio} 0
---------------------- POINTS ----------------------
ID  Attachment  X  Y  Z  M  V  CdA  CA
(#) (-) (m) (m) (m) (kg) (m^3) (m^2) (-)
1 Free {x} {y} {z - _SUBMERGENCE} {unit.mass} {unit.volume} {drag_area} {added}
2 Coupled 0 0 {-_SUBMERGENCE} 0 0 0 0
---------------------- LINES ----------------------
ID  LineType  AttachA  AttachB  UnstrLen  NumSegs  Outputs
(#) (name) (#) (#) (m) (-) (-)
1 line 1 2 {parameters.length} {parameters.segments} -
---------------------- OPTIONS ----------------------
0 writeLog
{step} dtM
{setting.scheme} tScheme
{parameters.water_density} WtrDnsty
{parameters.gravity} g
5000 WtrDpth
0 TmaxIC
---------------------- END ----------------------
"""


def run_moordyn(
    parameters: CableSimParameters,
    motion: Callable[[float], PointMotion],
    *,
    duration: float,
    tick: float = 0.05,
    setting: Setting = RK4,
    step: float | None = None,
) -> PeerRun:
    """Drive MoorDyn's line about the origin from the plant's own equilibrium; record unit and top tension each tick.

    Parameters
    ----------
    parameters : of the plant
    motion : of the top by time [s]
    duration : of the run [s]
    tick : interval of the records [s]
    setting : of MoorDyn
    step : of its time integration [s]; the largest stable one if None

    Raises
    ------
    ImportError
        where moordyn is not installed.
    RuntimeError
        where it finds no solution.
    """
    import moordyn  # noqa: PLC0415 (a peer for tests and benchmarks, not a dependency of a run)

    plant = CableDynamics(parameters)
    plant.start_at_equilibrium(np.zeros(3))
    step = largest_stable_step(parameters, setting) if step is None else step
    with tempfile.TemporaryDirectory() as folder, _silence():
        path = Path(folder) / "line.txt"
        path.write_text(input_file(parameters, plant.unit_position, setting, step), encoding="ascii")
        system = moordyn.Create(str(path))
        top = [0.0, 0.0, -_SUBMERGENCE]
        moordyn.Init(system, top, [0.0, 0.0, 0.0])
        unit, line = moordyn.GetPoint(system, 1), moordyn.GetLine(system, 1)
        count = round(duration / tick)
        times, positions = np.linspace(tick, count * tick, count), np.zeros((count, 3))
        tension = np.zeros(count)
        started = time.process_time()
        for k in range(count):
            # MoorDyn takes the position at the start of the step and the velocity over it
            start, end = motion(k * tick), motion((k + 1) * tick)
            velocity = (end.position - start.position) / tick
            place = start.position + np.array(top)
            if moordyn.Step(system, list(place), list(velocity), k * tick, tick) is None:
                raise RuntimeError(f"moordyn found no solution at {k * tick:g} s")
            positions[k] = moordyn.GetPointPos(unit)
            tension[k] = math.hypot(*moordyn.GetLineNodeTen(line, parameters.segments))
        used = time.process_time() - started
        moordyn.Close(system)
    return PeerRun(times, positions + np.array([0.0, 0.0, _SUBMERGENCE]), tension, used / duration)
