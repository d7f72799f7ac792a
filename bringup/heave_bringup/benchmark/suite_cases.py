"""Cases b2 to b10: the suite's scenarios, with the entrant in the controller's place."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from heave_node.parameters import flatten
from heave_node.scenario import WILDCARD
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_bringup.benchmark.case import Case, Problem
from heave_bringup.benchmark.interface import Facts, SeaFacts, SensorFacts, WinchFacts
from heave_bringup.benchmark.worlds.scenario_world import ScenarioWorld
from heave_bringup.campaign.campaign_file import find_campaign, read_campaign
from heave_bringup.scenarios import Scenario, load_scenario
from heave_bringup.settings import Setting

JUDGED = 600.0
"""Time judged of a run without a programme of its own [s]."""
SEEDS = tuple(range(1, 9))

STATIONARY = ("b2_calm_300", "b3_deep_900", "b4_limit_900_tp8", "b4_limit_900_tp10", "b4_limit_900_tp12", "b5_storm")
WITH_PROGRAMME = ("b6_resonance_payout", "b7_landing", "b8_faults")


def suite_cases() -> list[Case]:
    """Return the cases, in their order."""
    cases = [_case(name, load_scenario(name), judged=JUDGED) for name in STATIONARY]
    cases += [_case(name, load_scenario(name)) for name in WITH_PROGRAMME]
    cases.append(_model_error())
    cases.append(_case("b10_real_mru_swell", load_scenario("b10_real_mru_swell"), judged=JUDGED))
    return cases


def _case(name: str, scenario: Scenario, *, judged: float | None = None) -> Case:
    run = scenario.run
    duration = run.duration if judged is None else run.transient + judged
    make = _maker(name, name, lambda seed: [_of_all(name, "seed", seed)])
    return Case(name, _title(name), SEEDS, run.transient, duration, duration, make)


def _model_error() -> Case:
    """Return b9: draw k of the campaign for seed k, the belief being that of b3."""
    campaign = replace(read_campaign(find_campaign("b9_model_error")), duration=None)
    drawn = [case for case in campaign.cases() if not case.is_nominal]

    def settings(seed: int) -> list[Setting]:
        return campaign.settings_of(drawn[(seed - 1) % len(drawn)])

    make = _maker("b9_model_error", campaign.scenario, settings)
    run = load_scenario(campaign.scenario).run
    duration = run.transient + JUDGED
    return Case("b9_model_error", _title("b9_model_error"), SEEDS, run.transient, duration, duration, make)


def _maker(
    name: str, scenario_name: str, settings: Callable[[int], Sequence[Setting]]
) -> Callable[[int, float], Problem]:
    def make(seed: int, duration: float) -> Problem:
        scenario = load_scenario(scenario_name, settings=[*settings(seed), _of_all(name, "duration", duration)])
        definition = {"parameters": {node: flatten(values) for node, values in _world_of(scenario).items()}}
        return Problem(facts_of(name, scenario), ScenarioWorld(scenario), {**definition, "seed": seed})

    return make


def _of_all(case: str, name: str, value: object) -> Setting:
    """Return a change of what all nodes share."""
    return Setting(WILDCARD, name, value, f"case {case}")


def _world_of(scenario: Scenario) -> dict[str, object]:
    """Return the parameters that make the world, without those of the controller."""
    return {node: scenario.parameters[node] for node in ("wave_vessel", "cable_sim", "virtual_winch")}


def facts_of(name: str, scenario: Scenario) -> Facts:
    """Return what a controller knows by the scenario of the case `name`."""
    belief: WinchControllerParameters = scenario.parameters["winch_controller"]
    winch, sensors, sea = belief.winch, belief.sensors, belief.sea
    return Facts(
        case=name,
        sample_time=scenario.run.tick_period,
        duration=scenario.run.duration,
        winch=WinchFacts(
            time_constant=winch.time_constant,
            command_delay=winch.command_delay,
            speed_limit=winch.speed_limit,
            set_point_limit=winch.speed_limit,
            acceleration_limit=winch.acceleration_limit,
            payout_minimum=winch.payout_minimum,
            payout_maximum=winch.payout_maximum,
            position_gain=winch.position_gain,
        ),
        sensors=SensorFacts(
            mru_noise=sensors.mru.noise,
            mru_rate_noise=sensors.mru.rate_noise,
            mru_acceleration_noise=0.0,
            mru_high_pass_period=sensors.mru.high_pass_period,
            depth_noise=sensors.depth.noise,
            depth_latency=sensors.depth.latency,
            encoder_step=scenario.parameters["virtual_winch"].encoder.resolution,
        ),
        sea=SeaFacts(sea.significant_wave_height, sea.peak_period),
        belief=flatten(belief),
    )


def _title(name: str) -> str:
    return {
        "b2_calm_300": "3 t on 300 m, Hs 1 m, Tp 6 s",
        "b3_deep_900": "125 t on 900 m, Hs 1.5 m, Tp 10 s",
        "b4_limit_900_tp8": "the same, Hs 3 m, Tp 8 s",
        "b4_limit_900_tp10": "the same, Hs 3 m, Tp 10 s",
        "b4_limit_900_tp12": "the same, Hs 3 m, Tp 12 s",
        "b5_storm": "the same, Hs 6 m, Tp 12 s",
        "b6_resonance_payout": "125 t lowered from 50 to 900 m",
        "b7_landing": "125 t landed at 600 m and lifted off",
        "b8_faults": "one fault after another",
        "b9_model_error": "plant and winch differ from the controller's model",
        "b10_real_mru_swell": "wind sea and swell, an MRU with its faults",
    }[name]
