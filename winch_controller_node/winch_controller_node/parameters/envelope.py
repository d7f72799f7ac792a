"""Parameters of the envelope, the last bound on every order: margins and times. Where they come from is in its page."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import parameter


@dataclass(frozen=True)
class EnvelopeParameters:
    """The envelope: what speed and travel of the drum the ship's own motion explains, and what ends in the brake."""

    active: bool = parameter(
        True, unit="", description="Bound every order; false lets all orders pass, for trials in simulation only."
    )
    window: float = parameter(
        60.0, unit="s", minimum=5.0, maximum=600.0, description="Time over which the boom tip's motion is watched."
    )
    rate_factor: float = parameter(
        1.5,
        unit="",
        minimum=1.0,
        maximum=10.0,
        description="Largest speed about the requested move over the largest rate of the boom tip in the window.",
    )
    rate_margin: float = parameter(
        0.25, unit="m/s", minimum=0.0, maximum=10.0, description="Speed that is allowed beyond that."
    )
    travel_factor: float = parameter(
        1.5,
        unit="",
        minimum=1.0,
        maximum=10.0,
        description="Largest travel about the requested move over the largest heave of the boom tip in the window.",
    )
    travel_margin: float = parameter(
        0.3, unit="m", minimum=0.0, maximum=100.0, description="Travel that is allowed beyond that."
    )
    travel_time: float = parameter(
        60.0, unit="s", minimum=1.0, maximum=3600.0, description="Time constant with which travel is forgotten."
    )
    early_factor: float = parameter(
        2.5, unit="", minimum=1.0, maximum=10.0, description="Factor on both bounds while the window is empty."
    )
    lost_factor: float = parameter(
        0.8,
        unit="",
        minimum=0.1,
        maximum=1.0,
        description="Factor on both bounds while the drum's count or the MRU is lost.",
    )
    largest_heave: float = parameter(
        15.0, unit="m", minimum=0.1, maximum=50.0, description="Heave beyond which an MRU reading is implausible."
    )
    largest_rate: float = parameter(
        6.0, unit="m/s", minimum=0.1, maximum=50.0, description="Rate beyond which an MRU reading is implausible."
    )
    largest_acceleration: float = parameter(
        20.0,
        unit="m/s^2",
        minimum=1.0,
        maximum=1000.0,
        description="Change of the MRU's rate beyond which two readings in a row do not belong together.",
    )
    heave_step: float = parameter(
        0.2,
        unit="m",
        minimum=0.01,
        maximum=10.0,
        description="Step of the MRU's heave, beyond what its rate explains, that is a jump and is taken off.",
    )
    mru_time: float = parameter(
        2.0,
        unit="s",
        minimum=0.1,
        maximum=60.0,
        description="Time without a good reading after which the MRU is lost; above modes.coast_time.",
    )
    frozen_readings: int = parameter(
        10, unit="", minimum=2, maximum=10_000, description="Equal MRU readings in a row that count as frozen."
    )
    count_time: float = parameter(
        0.5,
        unit="s",
        minimum=0.05,
        maximum=60.0,
        description="Time without a good reading after which the drum's count is lost.",
    )
    count_step: float = parameter(
        0.05,
        unit="m",
        minimum=1e-3,
        maximum=10.0,
        description="Step of the count, beyond the drum's largest speed, that is a jump and is taken off.",
    )
    frozen_travel: float = parameter(
        0.1,
        unit="m",
        minimum=1e-3,
        maximum=10.0,
        description="Travel that was sent without a step of the count, after which the count is frozen.",
    )
    frozen_time: float = parameter(
        0.4, unit="s", minimum=0.05, maximum=60.0, description="Time that this takes at least."
    )
    drum_margin: float = parameter(
        0.1,
        unit="m",
        minimum=0.01,
        maximum=10.0,
        description="Distance of the count from the nominal drum at which the brake goes on.",
    )
    drum_share: float = parameter(
        0.4,
        unit="",
        minimum=0.0,
        maximum=5.0,
        description="Fraction of the travel of the last drum_time that is added to that distance.",
    )
    drum_time: float = parameter(
        1.0,
        unit="s",
        minimum=0.1,
        maximum=60.0,
        description="Time constant with which that distance is forgotten.",
    )
    brake_margin: float = parameter(
        0.025,
        unit="m",
        minimum=0.002,
        maximum=10.0,
        description="Motion of the count under the brake that is a slip; a single step of half of it is a jump.",
    )
    rest_speed: float = parameter(
        0.02, unit="m/s", minimum=1e-4, maximum=1.0, description="Speed below which a braked drum counts as at rest."
    )
    bound_time: float = parameter(
        0.5, unit="s", minimum=0.05, maximum=60.0, description="Time at a bound after which the envelope takes over."
    )
    bound_window: float = parameter(
        12.0, unit="s", minimum=1.0, maximum=600.0, description="Time within which that counts."
    )
    takeover_time: float = parameter(
        10.0,
        unit="s",
        minimum=0.5,
        maximum=600.0,
        description="Time over which the envelope's own order, the MRU's raw rate about the requested move, fades.",
    )
    damping_time: float = parameter(
        20.0,
        unit="s",
        minimum=0.0,
        maximum=600.0,
        description="Time for which it goes on to damp the load by the load cell, before the brake.",
    )
    damping_rate: float = parameter(
        0.2,
        unit="1/s",
        minimum=0.0,
        maximum=1.0,
        description="Speed, per metre of stretch of the nominal cable beyond its mean, with which it pays out to damp.",
    )
    fade_out_time: float = parameter(
        45.0, unit="s", minimum=1.0, maximum=3600.0, description="Longest fade-out while the MRU is good."
    )
    blind_time: float = parameter(
        960.0,
        unit="s",
        minimum=1.0,
        maximum=36_000.0,
        description="Longest fade-out without the MRU, in which the depth sensor damps the unit.",
    )
    unseen_time: float = parameter(
        12.0, unit="s", minimum=0.5, maximum=3600.0, description="Longest compensation without a good MRU reading."
    )
    stop_margin: float = parameter(
        0.05, unit="m/s", minimum=0.0, maximum=1.0, description="Speed about the ramp of a stop that is allowed."
    )
    stop_time: float = parameter(
        1.0, unit="s", minimum=0.0, maximum=60.0, description="Time after the end of that ramp until the brake goes on."
    )
    move_tolerance: float = parameter(
        1.0,
        unit="m",
        minimum=0.0,
        maximum=100.0,
        description="Distance of a requested move beyond that by the drum's count, or by the depth sensor.",
    )
    harm_ratio: float = parameter(
        1.3,
        unit="",
        minimum=1.0,
        maximum=10.0,
        description="Spread of the load cell, over that of the nominal cable with the winch locked, that is harm.",
    )
    harm_margin: float = parameter(
        0.01, unit="", minimum=0.0, maximum=1.0, description="Spread beyond that, over the static tension."
    )
    harm_time: float = parameter(
        10.0,
        unit="s",
        minimum=1.0,
        maximum=600.0,
        description="Time constant of those spreads, and time for which they must say so.",
    )
