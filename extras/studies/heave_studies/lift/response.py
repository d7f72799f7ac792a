"""The lift in the frequency domain: boom tip, cable and unit on the way of a phase, with the winch locked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from cable_sim_node.physics.properties import cable_sections
from cable_sim_node.vertical.axial_line import AxialLine, AxialUnit, axial_line
from cable_sim_node.vertical.linear import HeaveTransfer
from cable_sim_node.vertical.random_sea import gaussian_drag, sea_transfer_function
from heave_bringup.scenarios import Scenario
from heave_bringup.settings import Setting
from heave_node.crane.kinematics import Crane
from heave_node.loads.strength import Strength, strengths
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError, flatten
from heave_node.scenario import WILDCARD
from wave_vessel_node.sea.spectra import WaveSpectrum
from wave_vessel_node.sources.scene import Scene, build_scene

from heave_studies.lift.figures import GAUSSIAN, STILL, Motion, Place, Shape, Swing
from heave_studies.lift.plan import AIR, Phase, Plan

OMEGAS = np.linspace(0.15, 4.0, 250)
"""Frequencies that move a vessel [rad/s]."""
PLACES = 9
"""Places at which a phase is looked at."""
POSES = 7
"""Poses of a slewing crane that are looked at."""
HEIGHT, PERIOD = "system.sea.significant_wave_height", "system.sea.peak_period"


@dataclass(frozen=True)
class PhaseScene:
    """A phase in seas of one peak period."""

    phase: Phase  # of the plan
    period: float  # peak period [s]
    scenario: Scenario  # of the plan with the settings of the phase and a sea of 1 m
    lengths: Array  # of cable out at the places of the phase [m]
    arm: tuple[float, ...]  # boom tip from the vessel's reference point, in the pose that heaves most [m]
    density: Array  # spectrum of the boom tip's heave at Hs = 1 m, in that pose [m^2 s/rad], at OMEGAS

    @property
    def still_crane(self) -> dict[tuple[str, str], object]:
        """The boom tip of `arm` without a crane that could move it: settings of a run in which the crane stands."""
        moves = ("times", "slew", "luff", "knuckle", "extension")
        return {
            (WILDCARD, "system.vessel.boom_tip_arm"): list(self.arm),
            (WILDCARD, "system.crane.boom_length"): 0.0,
            **{("wave_vessel", f"crane.move_{name}"): [] for name in moves},
        }

    @property
    def strengths(self) -> tuple[Strength, ...]:
        """What the parts of the lift can carry, as far as the scenario states it."""
        return strengths(*(flatten(self.scenario.parameters[node]) for node in ("cable_sim", "virtual_winch")))

    @property
    def plant(self) -> Any:
        """Parameters of cable and unit."""
        return self.scenario.parameters["cable_sim"]

    def line(self, length: float) -> AxialLine:
        """Return cable and unit as the axial model knows them, with so much cable out: its `length` [m]."""
        plant = replace(self.plant, length=length)
        line = axial_line(plant)
        if self.phase.kind != AIR:
            return line
        weights = [one.cable.weight_in_air for one in cable_sections(plant)]
        sections = [replace(one, weight=weight, drag=0.0) for one, weight in zip(line.sections, weights, strict=True)]
        return AxialLine(tuple(sections), AxialUnit(plant.unit.mass, plant.unit.mass * plant.gravity))


def phase_scene(plan: Plan, phase: Phase, period: float, extra: Sequence[Setting] = ()) -> PhaseScene:
    """Return a phase in seas of one peak period.

    Parameters
    ----------
    plan, phase : of the lift
    period : peak period [s]
    extra : settings on top

    Raises ParameterError for settings that do not fit, and a depth that leaves no cable.
    """
    where = f"{plan.path}: {phase.name}"
    sea = [Setting(WILDCARD, HEIGHT, 1.0, where), Setting(WILDCARD, PERIOD, period, where)]
    scenario = plan.with_settings([*phase.settings, *sea, *extra])
    first, last = phase.does.depth
    depths = np.linspace(first, last, PLACES if first != last else 1)
    lengths = depths + scenario.parameters["cable_sim"].boom_tip_height
    if lengths.min() <= 0.0:
        raise ParameterError(
            f"{where}: depth = {list(phase.does.depth)}: lies above the boom tip, which is "
            f"{scenario.parameters['cable_sim'].boom_tip_height:g} m above the water (system.boom_tip_height)"
        )
    scene = build_scene(scenario.parameters["wave_vessel"], scenario.run.seed, scenario.run.tick_period)
    if scene.spectrum is None:
        raise ParameterError(f"{where}: its boom tip has no sea: set wave_vessel.boom_tip_source to spectrum")
    tips = [(arm, _density(scene, scene.spectrum, arm)) for arm in _arms(scenario, phase, where)]
    arm, density = max(tips, key=lambda tip: float(np.sum(tip[1] * OMEGAS**4)))
    return PhaseScene(phase, period, scenario, lengths, arm, density)


def _arms(scenario: Scenario, phase: Phase, where: str) -> list[tuple[float, ...]]:
    """Return where the boom tip is on the way of the crane."""
    vessel, crane = scenario.parameters["wave_vessel"].vessel, scenario.parameters["wave_vessel"].crane
    if not phase.does.slew:
        return [tuple(vessel.boom_tip_arm)]
    if not crane.is_fitted or vessel.model != "rao":
        raise ParameterError(f"{where}: slew: needs a crane (system.crane.boom_length) on a vessel with RAOs")
    _, *others = crane.reference
    tip, (first, last) = Crane(crane), phase.does.slew
    places = [tip.tip((slew, *others)).arm for slew in np.linspace(first, last, POSES)]
    return [tuple(float(a + b) for a, b in zip(vessel.boom_tip_arm, place, strict=True)) for place in places]


def _density(scene: Scene, spectrum: WaveSpectrum, arm: tuple[float, ...]) -> Array:
    parameters = scene.parameters
    moved = replace(parameters, vessel=replace(parameters.vessel, boom_tip_arm=arm))
    return np.asarray(spectrum.density(OMEGAS) * replace(scene, parameters=moved).power_response(OMEGAS))


def locked_places(scene: PhaseScene, height: float, shape: Shape = GAUSSIAN) -> list[Place]:
    """Return how unit and cable move with the winch locked on its mean speed, drag linearised in this sea.

    Parameters
    ----------
    scene : of the phase
    height : significant wave height [m]
    shape : of the distribution of the tensions; that of the heave has no skewness
    """
    density = scene.density * height**2
    return [_place(scene, float(length), density, shape) for length in scene.lengths]


def _place(scene: PhaseScene, length: float, density: Array, shape: Shape) -> Place:
    line, rate = scene.line(length), scene.phase.rate
    transfer = sea_transfer_function(line, length, OMEGAS, density, speed=abs(rate))
    answers = (transfer.top_tension, _at_unit(line, transfer, density, abs(rate)), transfer.unit_heave)
    shapes = (shape, shape, Shape(shape.kurtosis))
    swings = (swing(density * np.abs(a) ** 2)._replace(shape=of) for a, of in zip(answers, shapes, strict=True))
    return Place(
        duration=scene.phase.duration / scene.lengths.size,
        static=static_tension(scene, length),
        drag=-math.copysign(_towed_drag(line, length) * rate**2, rate),
        weight=line.unit.weight,
        speed=rate,
        motion=Motion(*swings),
    )


def static_tension(scene: PhaseScene, length: float) -> float:
    """Return the top tension of a `scene` at rest, with a `length` of cable out [m]: what is above water in air [N]."""
    line = scene.line(length)
    above = min(scene.plant.boom_tip_height, length)
    section = cable_sections(scene.plant)[-1].cable
    dry = (
        0.0 if scene.phase.kind == AIR or not scene.plant.surface else above * (section.weight_in_air - section.weight)
    )
    return line.static_top_tension(length) + dry


def _at_unit(line: AxialLine, transfer: HeaveTransfer, density: Array, speed: float) -> Array:
    """Return the tension at the unit over boom-tip heave: what accelerates the unit and overcomes its drag."""
    moved = transfer.unit_heave
    sigma = math.sqrt(float(np.sum(density * np.abs(OMEGAS * moved) ** 2)) * (OMEGAS[1] - OMEGAS[0]))
    damping = line.unit.drag * gaussian_drag(np.array(sigma), speed)
    return np.asarray((1j * OMEGAS * damping - line.unit.inertia * OMEGAS**2) * moved)


def _towed_drag(line: AxialLine, length: float) -> float:
    """Return the drag of unit and cable that move alike, over the square of their speed [N s2/m2]."""
    return line.unit.drag + sum(piece.drag * piece.length for piece in line.pieces(length))


def swing(density: Array) -> Swing:
    """Return how a signal swings, from its one-sided spectrum `density` at OMEGAS."""
    step = OMEGAS[1] - OMEGAS[0]
    m0, m1, m2 = (float(np.sum(density * OMEGAS**power)) * step for power in (0, 1, 2))
    if m0 <= 0.0:
        return STILL
    width = math.sqrt(max(1.0 - m1**2 / (m0 * m2), 0.0))
    return Swing(math.sqrt(m0), math.sqrt(m2 / m0) / (2.0 * math.pi), width)
