"""The published cases: the hydraulic winch of Zinage & Somayajula, the drawworks of MAS410, the lowering of MAS409."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from cable_sim_node.winch.drive_parameters.motion import FrictionParameters, MotionParameters
from cable_sim_node.winch.drive_parameters.valve import (
    FluidParameters,
    ServoValveParameters,
    SupplyParameters,
    ValveDriveParameters,
)
from cable_sim_node.winch.drives.published import (
    LITRES_PER_MINUTE,
    mas410_published_solution,
    mas410_radians_per_metre,
    zinage_drive,
)
from cable_sim_node.winch.drives.pump_controlled import PumpDrive
from cable_sim_node.winch.drives.valve_controlled import ValveDrive
from cable_sim_node.winch.parameters import WinchParameters
from heave_node.parameters import ParameterError, build_parameters, flatten
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_bringup.benchmark.case import Case, Problem
from heave_bringup.benchmark.interface import Facts, SeaFacts, SensorFacts, WinchFacts
from heave_bringup.benchmark.records import HOW, find_record, read_record
from heave_bringup.benchmark.target import TargetProgramme
from heave_bringup.benchmark.worlds.loads import CarriedLoad, HangingLoad, Kinematics, Load, WetLoad, mas409_load
from heave_bringup.benchmark.worlds.motions import Motion, RecordedMotion, mas409_sea, sine
from heave_bringup.benchmark.worlds.rigid_world import RigidProblem, RigidWorld
from heave_bringup.benchmark.worlds.winches import DrivenWinch, VirtualWinchUnderTest, Winch

PERFECT = SensorFacts(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
NOISY = SensorFacts(0.01, 0.01, 0.01, 0.0, 0.02, 0.1, 0.001)
NOISY_DRAWWORKS = replace(NOISY, load_cell_noise=1000.0)
"""MAS410: as in the other noisy cases, and a load cell with half a percent of the load."""
SHIPS_ACCELEROMETER = SensorFacts(0.01, 0.01, 0.5, 0.0, 0.02, 0.1, 0.001, 500.0)
"""MAS409: the vessel's acceleration is measured with noise of 0.5 m/s^2. The load cell has half a percent of the load:
one without noise reads the same again and again on a slack rope, as one that is dead."""

RIGID_ROPE: dict[str, object] = {"cable.axial_stiffness": 1e12, "cable_model.damping": 1e-3}
"""What this suite's controller assumes of a rope that does not stretch: its load does not swing on it for a tick."""

ONE_PERIOD: dict[str, object] = {"sea.spectrum": "jonswap", "sea.peak_enhancement": 10.0}
"""MAS410: its wave has one period, as its task says. That is the narrowest sea that can be assumed."""

TICK = 0.05
QUICK = 0.005
"""Sample time with perfect sensors [s]: published laws are given in continuous time."""
RAMP = 10.0
"""Time over which a sea or a wave of the benchmark's own making grows [s]."""

ROLL_OFF = 3.0
"""Frequency above which a boom tip is assumed to follow the waves less and less, over the peak frequency."""
MAS409_PEAK_PERIOD = 10.0 / (0.8 * 0.44) ** 0.25
"""Peak period of A/w^5 exp(-B/w^4) with B = 0.44 w1^4 and a mean period T1 = 10 s: w_p^4 = 4 B/5 [s]."""

ZINAGE_SEAS: dict[str, tuple[float, float, dict[str, float]]] = {
    "slight": (0.11, 6.0, {}),
    "moderate": (1.0, 9.0, {"PID": 0.02740, "LQI": 0.03177}),
    "rough": (3.4, 12.0, {"PID": 0.07197, "LQI": 0.08264}),
}
"""Four standard deviations of the expected heave [m], peak period of the sea [s], published residuals [m, rms]."""


def published_cases(records: Path | None) -> list[Case]:
    """Return the cases; those on records raise ParameterError when made where `records` has none."""
    cases = []
    for sea, (_, _, published) in ZINAGE_SEAS.items():
        for kind, seeds in (("", (1,)), ("_noisy", tuple(range(1, 9)))):
            title = f"Zinage & Somayajula, {sea} sea, {'noisy' if kind else 'perfect'} sensors"
            make = _zinage_maker(f"z_{sea}{kind}", sea, records, is_noisy=bool(kind))
            cases.append(Case(f"z_{sea}{kind}", title, seeds, 100.0, 500.0, 500.0, make, published))
    return [*cases, *_mas410_cases(), *_mas409_cases()]


def _problem(
    facts: Facts,
    motion: Motion,
    make_winch: Callable[[], Winch],
    make_load: Callable[[Kinematics], Load],
    seed: int,
    definition: Mapping[str, object],
) -> Problem:
    """Return a problem without a cable model."""
    belief = build_parameters(WinchControllerParameters, facts.belief, where=f"case {facts.case}")
    world = RigidWorld(
        RigidProblem(
            sample_time=facts.sample_time,
            duration=facts.duration,
            motion=motion,
            make_winch=make_winch,
            make_load=make_load,
            sensors=facts.sensors,
            make_target=lambda: TargetProgramme(belief, sample_time=facts.sample_time),
            speed_limit=facts.winch.speed_limit,
            acceleration_limit=facts.winch.acceleration_limit,
            seed=seed,
        )
    )
    return Problem(facts, world, {**definition, "seed": seed}, motion)


def _belief(winch: WinchFacts, sea: SeaFacts, sensors: SensorFacts, mass: float, **more: object) -> dict[str, object]:
    """Return what this suite's controller assumes: a load on a short stiff rope in air, the winch and the sea.

    The boom tip is said to move as a sea of that height would, which is what its heave is expected to be, but not with
    waves far shorter than the longest: a hull does not follow waves shorter than itself.
    """
    values: dict[str, object] = {
        "length": 20.0,
        "water_density": 0.0,
        "unit.mass": mass,
        "unit.added_mass": (0.0, 0.0, 0.0),
        "winch.time_constant": winch.time_constant,
        "winch.command_delay": winch.command_delay,
        "winch.speed_limit": winch.speed_limit,
        "winch.set_point_reach": winch.set_point_limit / winch.speed_limit,
        "winch.payout_minimum": winch.payout_minimum,
        "winch.payout_maximum": winch.payout_maximum,
        "sea.significant_wave_height": sea.significant_wave_height,
        "sea.peak_period": sea.peak_period,
        "vessel.model": "second_order",
        "vessel.natural_frequency": ROLL_OFF * 2.0 * math.pi / sea.peak_period,
        "vessel.damping_ratio": 0.7,
        "vessel.gain": 1.0,
        "sensors.mru.noise": max(sensors.mru_noise, 1e-3),
        "sensors.mru.rate_noise": max(sensors.mru_rate_noise, 1e-3),
        "sensors.depth.noise": max(sensors.depth_noise, 1e-3),
        "sensors.depth.latency": sensors.depth_latency,
        **more,
    }
    values["winch.acceleration_limit"] = min(winch.acceleration_limit, 1e6)
    return dict(flatten(build_parameters(WinchControllerParameters, values, where="belief")))


# Zinage & Somayajula


def _zinage_maker(name: str, sea: str, records: Path | None, *, is_noisy: bool) -> Callable[[int, float], Problem]:
    def make(seed: int, duration: float) -> Problem:
        path = find_record(records, sea)
        if path is None:
            raise ParameterError(f"case {name} needs the record of the {sea} sea, which is not shipped: {HOW}")
        record = read_record(path)
        height, period, _ = ZINAGE_SEAS[sea]
        drive, expected = zinage_drive(), SeaFacts(height, period)
        sample_time, sensors = (TICK, NOISY) if is_noisy else (QUICK, PERFECT)
        winch = WinchFacts(
            time_constant=drive.swash_time_constant,
            command_delay=0.0,
            speed_limit=drive.motion.speed_limit,
            set_point_limit=drive.swash_input_limit * drive.motion.speed_limit,
            acceleration_limit=math.inf,
            payout_minimum=-50.0,
            payout_maximum=50.0,
        )
        belief = _belief(winch, expected, sensors, drive.load_mass)
        facts = Facts(name, sample_time, duration, winch, sensors, expected, belief)

        def make_winch() -> Winch:
            return DrivenWinch(PumpDrive(drive), encoder_step=sensors.encoder_step, sample_time=sample_time)

        definition = {"drive": flatten(drive), "record": record.digest}
        motion = RecordedMotion(record)
        return _problem(facts, motion, make_winch, lambda start: CarriedLoad(0.0, start), seed, definition)

    return make


# MAS410

SOLUTION_FASTEST, DRAWWORKS_FASTEST = 0.85, 1.0
"""Hoisting speed of the two drawworks with all valves open [m/s]: 250 bar against 218, 240 against 152."""


def _mas410_cases() -> list[Case]:
    """Return the published solution and a drawworks of 2024; judged over four waves, once any controller has begun."""
    cases = []
    for kind, seeds in (("", (1,)), ("_noisy", tuple(range(1, 9)))):
        sensors = f"{'noisy' if kind else 'perfect'} sensors"
        for name, title, drive, mass, fastest, motion, published in (
            (
                "u1_solution",
                "the drawworks of a published solution",
                mas410_published_solution(),
                18_000.0,
                SOLUTION_FASTEST,
                sine(1.5, 10.0, ramp=RAMP),
                {"over time steps": 0.00345},
            ),
            (
                "u1_drawworks",
                "the task of 2024, a drawworks sized by its rules",
                mas410_drawworks(),
                24_000.0,
                DRAWWORKS_FASTEST,
                sine(1.2, 10.0, ramp=RAMP),
                {},
            ),
        ):
            make = _drawworks_maker(f"{name}{kind}", drive, mass, fastest, motion, is_noisy=bool(kind))
            cases.append(Case(f"{name}{kind}", f"MAS410, {title}, {sensors}", seeds, 50.0, 90.0, 90.0, make, published))
    return cases


def mas410_drawworks() -> ValveDriveParameters:
    """Return a drawworks for MAS410's task of 2024, sized by its rules.

    24 t, 3 sheaves, gear 7, 1.2 m in 10 s: two motors of 90 cm^3 keep the load pressure below two thirds of 240 bar
    with friction and inertia; five valves of 200 l/min (35 bar an edge) pass 1,070 l/min against it, and 850 are
    needed. The supply is ideal (2,000 l/min), leakage gives 0.94 at 4,500 rpm and 350 bar. The speed loop is an
    integral one; its feed-forward lies between what lowering needs (0.48 s/m) and hoisting (0.95 s/m), and its gain is
    such that it lags 4 ms at the waves' frequency, and nowhere more than 12 ms.
    """
    n = mas410_radians_per_metre(3, 7.0)
    displacement = 2.0 * 90e-6 / (2.0 * math.pi)
    fastest = 4500.0 * 2.0 * math.pi / 60.0
    return ValveDriveParameters(
        motion=MotionParameters(speed_limit=1.0, overspeed=1.2, payout_minimum=-20.0, payout_maximum=20.0),
        friction=FrictionParameters(load=0.15, slip_speed=5.0 / n),
        fluid=FluidParameters(leakage=displacement * fastest * (1.0 / 0.94 - 1.0) / 350e5),
        valve=ServoValveParameters(rated_flow=5.0 * 200.0 * LITRES_PER_MINUTE),
        supply=SupplyParameters(pressure=240e5),
        motor_displacement=displacement,
        motor_radians_per_metre=n,
        motor_inertia=2.0 * 0.0116,
        load_mass=24_000.0,
        gain=0.3,
        feed_forward=0.6,
        integral_time=0.01,
    )


def _drawworks_maker(
    name: str, drive: ValveDriveParameters, mass: float, fastest: float, motion: Motion, *, is_noisy: bool
) -> Callable[[int, float], Problem]:
    weight = mass * 9.81

    def make(seed: int, duration: float) -> Problem:
        sample_time, sensors = (TICK, NOISY_DRAWWORKS) if is_noisy else (QUICK, PERFECT)
        sea = SeaFacts(4.0, 10.0)
        winch = WinchFacts(
            time_constant=0.005,
            command_delay=0.0,
            speed_limit=fastest,
            set_point_limit=2.0 * fastest,
            acceleration_limit=4.8,
            payout_minimum=-20.0,
            payout_maximum=20.0,
        )
        # the drive carries the load: tension is constant, and no limit of the plan
        rope = {**RIGID_ROPE, "limits.minimum_tension_ratio": 0.0}
        belief = _belief(winch, sea, sensors, mass, **rope, **ONE_PERIOD)
        facts = Facts(name, sample_time, duration, winch, sensors, sea, belief)

        def make_winch() -> Winch:
            moved = ValveDrive(drive, tension=weight)
            return DrivenWinch(moved, encoder_step=sensors.encoder_step, sample_time=sample_time)

        definition = {"drive": flatten(drive)}
        return _problem(facts, motion, make_winch, lambda start: CarriedLoad(weight, start), seed, definition)

    return make


# MAS409


def _mas409_cases() -> list[Case]:
    """Return hold at 7.5 m above the bottom, lower to 5 m, and land from there; tolerance 4 cm."""
    tolerance, seeds = {"tolerance": 0.04}, tuple(range(1, 9))
    lower = {"programme.move_times": (120.0,), "programme.move_payouts": (2.5,), "programme.move_speeds": (0.1,)}
    land = {"programme.move_times": (120.0,), "programme.move_payouts": (5.3,), "programme.move_speeds": (0.1,)}

    def case(name: str, title: str, end: float, duration: float, height: float, programme: dict[str, object]) -> Case:
        make = _mas409_maker(name, mas409_load(height), programme)
        return Case(name, title, seeds, 60.0, end, duration, make, tolerance)

    return [
        case("u2_hold", "MAS409, hold 7.5 m above the bottom", 360.0, 360.0, 7.5, {}),
        case("u2_lower", "MAS409, lower from 7.5 to 5 m", 300.0, 300.0, 7.5, dict(lower)),
        case("u2_land", "MAS409, land from 5 m", 160.0, 300.0, 5.0, dict(land)),
    ]


def _mas409_maker(name: str, load: WetLoad, programme: dict[str, object]) -> Callable[[int, float], Problem]:
    def make(seed: int, duration: float) -> Problem:
        parameters, sea = WinchParameters(), SeaFacts(1.7, MAS409_PEAK_PERIOD)
        winch = WinchFacts(
            time_constant=parameters.time_constant,
            command_delay=parameters.command_delay,
            speed_limit=parameters.speed_limit,
            set_point_limit=parameters.speed_limit,
            acceleration_limit=parameters.acceleration_limit,
            payout_minimum=parameters.payout_minimum,
            payout_maximum=parameters.payout_maximum,
        )
        belief = _belief(
            winch,
            sea,
            SHIPS_ACCELEROMETER,
            load.mass,
            water_density=1025.0,
            **{"unit.volume": 2.0, "unit.drag_coefficient": (1.8,) * 3, "unit.drag_area": (1.5,) * 3},
            **RIGID_ROPE,
            **programme,
        )
        facts = Facts(name, TICK, duration, winch, SHIPS_ACCELEROMETER, sea, belief)

        def make_winch() -> Winch:
            return VirtualWinchUnderTest(parameters, sample_time=TICK)

        definition = {"winch": flatten(parameters), "load": dict(load._asdict())}
        motion = mas409_sea(seed, ramp=RAMP)
        return _problem(facts, motion, make_winch, lambda start: HangingLoad(load, start), seed, definition)

    return make
