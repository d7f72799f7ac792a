"""Which cases a screening covers: those of which every parameter it knows nothing of is at its default."""

from __future__ import annotations

from collections.abc import Mapping

from heave_bringup.nodes import NODES
from heave_bringup.scenarios import Scenario
from heave_node.parameters import Value, flatten
from heave_node.system_parameters import owned_names, system_names

COVERED: Mapping[str, tuple[str, ...]] = {
    "wave_vessel": (
        *("significant_wave_height", "peak_period", "spectrum", "peak_enhancement", "shape", "swell.", "spreading."),
        *("components", "direction", "ramp", "boom_tip_height", "vessel.", "course.heading", "course.speed", "filter."),
        *("spectrum_file", "spectrum_record", "spectrum_time", "accept_implausible", "estimate.", "preview.noise"),
        *("mru.rate", "mru.noise", "mru.rate_noise", "mru.wander", "mru.resolution", "mru.rate_resolution"),
        *("mru.high_pass_period", "mru.high_pass_damping", "mru.scale_error", "mru.latency"),
    ),
    "cable_sim": (
        *("length", "segments", "current", "current_profile.", "water_density", "gravity", "surface", "cable."),
        *("unit.", "seabed.", "solver.", "boom_tip_height", "linear.", "sensors.depth.rate", "sensors.depth.latency"),
        *("sensors.depth.noise", "sensors.velocity.", "sensors.imu.", "sensors.usbl.", "sensors.load_cell."),
    ),
    "virtual_winch": (
        *("time_constant", "command_delay", "speed_limit", "acceleration_limit", "stop_deceleration", "payout_minimum"),
        *("payout_maximum", "power_limit", "rated_pull", "hauling_speed_share", "hauling_acceleration_share"),
        *("command_timeout", "supervision_time", "encoder.resolution"),
    ),
    "winch_controller": (
        *("law", "lqg.", "mpc.", "industrial.", "feedforward.", "weights.", "estimator.", "length", "water_density"),
        *("gravity", "boom_tip_height", "cable.", "unit.", "winch.time_constant", "winch.command_delay"),
        *("winch.speed_limit", "winch.acceleration_limit", "winch.payout_minimum", "winch.payout_maximum"),
        *("winch.power_limit", "winch.disturbance", "sea.", "vessel.", "sensors.", "limits.", "guard.", "lag."),
        *("modes.settling_time", "modes.fade_in_time", "modes.fade_out_time", "modes.coast_time", "modes.resume"),
        *("tension.", "envelope.", "alarms.", "entry.", "move.", "operator.", "health."),
    ),
}
"""Parameters by node that a screening covers; a group ends with a point."""

OF_NO_CABLE = "system.linear."
"""Words of the linear plant, which stand beside those of the cable."""

LAWS = ("off", "lqg", "mpc")
"""Laws that are u = -G x away from their limits, or hold the winch."""


def not_covered(scenario: Scenario) -> str:
    """Return why no screening covers a `scenario`, in words; "" where one does."""
    law = scenario.parameters["winch_controller"].law
    if law not in LAWS:
        return f"law {law}"
    own = {node.name: flatten(scenario.parameters[node.name]) for node in NODES}
    for node, covered in COVERED.items():
        usual = flatten(type(scenario.parameters[node])())
        for name, value in own[node].items():
            if value != usual[name] and not any(_covers(word, name) for word in covered):
                return f"{node}.{name} = {value}"
    return _differing(own)


def _covers(word: str, name: str) -> bool:
    return name.startswith(word) if word.endswith(".") else name == word


def _differing(own: Mapping[str, Mapping[str, Value]]) -> str:
    """Return which node assumes another system than the owner of a parameter: the adviser would find out."""
    system: dict[str, Value] = {}
    for node, values in own.items():
        system |= {name: values[mine] for name, mine in owned_names(node, values).items()}
    for node, values in own.items():
        for name, mine in system_names(node, values).items():
            if values[mine] != system[name] and not name.startswith(OF_NO_CABLE):
                return f"{node}.{mine} = {values[mine]}, {name} = {system[name]}"
    return ""
