"""Parameters of the vessel: how she answers the sea, and her course."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import parameter

VESSEL_MODELS = ("second_order", "rao", "fitted", "direct")


@dataclass(frozen=True)
class VesselAnswer:
    """What sea and controller state alike of how the vessel answers the sea."""

    model: str = parameter("second_order",
        description="second_order (thesis Eq. 6.25), rao (table, 6 DOF; to a controller as fitted), fitted (second "
        "order, to the rao), direct.", choices=VESSEL_MODELS)  # fmt: skip
    natural_frequency: float = parameter(0.9, "rad/s", 0.01, 10.0, "omega_v of the second-order vessel.")
    damping_ratio: float = parameter(0.4, "", 0.01, 5.0, "xi_v of the second-order vessel.")
    rao_file: str = parameter("",
        description="RAO table (models rao, fitted), .csv or Capytaine .nc; empty uses the hull form shipped with the "
        "package.")  # fmt: skip
    boom_tip_arm: tuple[float, ...] = parameter((-20.0, 10.0, 15.0), "m", -500.0, 500.0,
        "Boom tip from the vessel's reference point (x forward, y port, z up); models rao, fitted.",
        length=3)  # fmt: skip


@dataclass(frozen=True)
class VesselParameters(VesselAnswer):
    """How the vessel answers the sea."""

    gain: float = parameter(1.0, "", 0.0, 10.0, "K_v: boom-tip heave per wave elevation at low frequency.")
    pitch_gain: float = parameter(0.0, "", 0.0, 5.0,
        "Pitch of the second-order vessel per wave slope at low frequency (odometry, lever-arm error).")  # fmt: skip


@dataclass(frozen=True)
class CourseParameters:
    """Heading and forward speed, and one change of them. They matter to model rao (encounter) and to the MRU (turn)."""

    heading: float = parameter(0.0, "rad", -6.3, 6.3, "Heading of the vessel from world x, anticlockwise.")
    speed: float = parameter(0.0, "m/s", 0.0, 15.0, "Forward speed.")
    turn_start: float = parameter(0.0, "s", 0.0, None, "Time at which the turn starts.")
    turn_angle: float = parameter(0.0, "rad", -20.0, 20.0, "Change of heading; 6.2832 is a full circle, 0 means none.")
    turn_rate: float = parameter(0.01, "rad/s", 1e-4, 0.2, "Largest rate of turn during the change of heading.")
    speed_change_start: float = parameter(0.0, "s", 0.0, None, "Time at which the speed changes.")
    speed_change: float = parameter(0.0, "m/s", -15.0, 15.0, "Change of the forward speed; 0 means none.")
    speed_change_duration: float = 60.0  # duration of the change of speed [s]


@dataclass(frozen=True)
class DriftParameters:
    """Slow drift of the vessel on its position keeping."""

    standard_deviation: tuple[float, ...] = parameter((0.0, 0.0), "m", 0.0, 100.0,
        "Standard deviation of the slow drift in surge and sway; 0 means none.", length=2)  # fmt: skip
    period: float = parameter(120.0, "s", 20.0, 1000.0, "Natural period of the drift under mooring or DP.")
    damping_ratio: float = 0.15  # damping ratio of the slow drift [-]
