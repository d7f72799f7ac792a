"""Parameters of the vessel: how she answers the sea, and her course."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import parameter

VESSEL_MODELS = ("second_order", "rao", "fitted", "direct")


@dataclass(frozen=True)
class VesselAnswer:
    """What sea and controller state alike of how the vessel answers the sea."""

    model: str = parameter(
        "second_order",
        unit="",
        choices=VESSEL_MODELS,
        description="second_order (thesis Eq. 6.25), rao (table, 6 DOF; to a controller as fitted), fitted (second "
        "order, to the rao), direct.",
    )
    natural_frequency: float = parameter(
        0.9, unit="rad/s", minimum=0.01, maximum=10.0, description="omega_v of the second-order vessel."
    )
    damping_ratio: float = parameter(
        0.4, unit="", minimum=0.01, maximum=5.0, description="xi_v of the second-order vessel."
    )
    rao_file: str = parameter(
        "",
        unit="",
        description="RAO table (models rao, fitted), .csv or Capytaine .nc; empty uses the hull form shipped with the "
        "package.",
    )
    boom_tip_arm: tuple[float, ...] = parameter(
        (-20.0, 10.0, 15.0),
        unit="m",
        minimum=-500.0,
        maximum=500.0,
        length=3,
        description="Boom tip from the vessel's reference point (x forward, y port, z up); models rao, fitted.",
    )


@dataclass(frozen=True)
class VesselParameters(VesselAnswer):
    """How the vessel answers the sea."""

    gain: float = parameter(
        1.0, unit="", minimum=0.0, maximum=10.0, description="K_v: boom-tip heave per wave elevation at low frequency."
    )
    pitch_gain: float = parameter(
        0.0,
        unit="",
        minimum=0.0,
        maximum=5.0,
        description="Pitch of the second-order vessel per wave slope at low frequency (odometry, lever-arm error).",
    )


@dataclass(frozen=True)
class CourseParameters:
    """Heading and forward speed, and one change of them. They matter to model rao (encounter) and to the MRU (turn)."""

    heading: float = parameter(
        0.0, unit="rad", minimum=-6.3, maximum=6.3, description="Heading of the vessel from world x, anticlockwise."
    )
    speed: float = parameter(0.0, unit="m/s", minimum=0.0, maximum=15.0, description="Forward speed.")
    turn_start: float = parameter(0.0, unit="s", minimum=0.0, description="Time at which the turn starts.")
    turn_angle: float = parameter(
        0.0,
        unit="rad",
        minimum=-20.0,
        maximum=20.0,
        description="Change of heading; 6.2832 is a full circle, 0 means none.",
    )
    turn_rate: float = parameter(
        0.01, unit="rad/s", minimum=1e-4, maximum=0.2, description="Largest rate of turn during the change of heading."
    )
    speed_change_start: float = parameter(0.0, unit="s", minimum=0.0, description="Time at which the speed changes.")
    speed_change: float = parameter(
        0.0, unit="m/s", minimum=-15.0, maximum=15.0, description="Change of the forward speed; 0 means none."
    )
    speed_change_duration: float = parameter(
        60.0, unit="s", minimum=1.0, description="Duration of the change of speed."
    )


@dataclass(frozen=True)
class DriftParameters:
    """Slow drift of the vessel on its position keeping."""

    standard_deviation: tuple[float, ...] = parameter(
        (0.0, 0.0),
        unit="m",
        minimum=0.0,
        maximum=100.0,
        length=2,
        description="Standard deviation of the slow drift in surge and sway; 0 means none.",
    )
    period: float = parameter(
        120.0, unit="s", minimum=20.0, maximum=1000.0, description="Natural period of the drift under mooring or DP."
    )
    damping_ratio: float = parameter(
        0.15, unit="", minimum=0.02, maximum=1.0, description="Damping ratio of the slow drift."
    )
