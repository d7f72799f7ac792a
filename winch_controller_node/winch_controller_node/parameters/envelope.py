"""Parameters of the envelope, the last bound on every order: margins and times. Where they come from is in its page."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import parameter


@dataclass(frozen=True)
class EnvelopeParameters:
    """The envelope: what speed and travel of the drum the ship's own motion explains, and what ends in the brake.

    Fields without a range are constants of every run.
    """

    active: bool = parameter(True,
        description="Limit every command; false passes all commands, for simulation only.")  # fmt: skip
    window: float = 60.0  # time over which the boom tip's motion is watched [s]
    # speed limit relative to the requested move, as a multiple of the largest boom-tip rate [-]
    rate_factor: float = 1.5
    rate_margin: float = parameter(0.25, "m/s", 0.0, 10.0, "Speed allowed beyond envelope.rate_factor.")
    # travel limit relative to the requested move, as a multiple of the largest boom-tip heave [-]
    travel_factor: float = 1.5
    travel_margin: float = parameter(0.3, "m", 0.0, 100.0, "Travel allowed beyond envelope.travel_factor.")
    travel_time: float = 60.0  # time constant with which travel decays [s]
    early_factor: float = 2.5  # factor on both bounds while the window is empty [-]
    lost_factor: float = 0.8  # factor on both bounds while the drum's count or the MRU is lost [-]
    largest_heave: float = 15.0  # heave beyond which an MRU reading is implausible [m]
    largest_rate: float = 6.0  # rate beyond which an MRU reading is implausible [m/s]
    # change of the MRU's rate beyond which two readings in a row do not belong together [m/s^2]
    largest_acceleration: float = 20.0
    # step of the MRU's heave, beyond what its rate explains, that is a jump and is taken off [m]
    heave_step: float = 0.2
    mru_time: float = 2.0  # time without a good reading after which the MRU is lost; above modes.coast_time [s]
    frozen_readings: int = 10  # equal MRU readings in a row that count as frozen
    count_time: float = 0.5  # time without a good reading after which the drum's count is lost [s]
    count_step: float = 0.05  # step of the count, beyond the drum's largest speed, that is a jump and is taken off [m]
    frozen_travel: float = 0.1  # travel that was sent without a step of the count, after which the count is frozen [m]
    frozen_time: float = 0.4  # time that this takes at least [s]
    drum_margin: float = parameter(0.1, "m", 0.01, 10.0,
        "Distance of the count from the nominal drum at which the brake engages.")  # fmt: skip
    drum_share: float = 0.4  # fraction of the travel of the last drum_time that is added to that distance [-]
    drum_time: float = 1.0  # time constant with which that distance decays [s]
    # speed and acceleration of the count, over the largest recently commanded, that are allowed [-]
    stroke_factor: float = 1.5
    stroke_margin: float = 0.02  # travel allowed beyond that, in addition to two steps of the count [m]
    stroke_gain: float = 0.7  # weight of the check of acceleration relative to that of speed [-]: a drive may overshoot
    stroke_late: float = 0.6  # additional lag that a drive may have beyond the stated one [s]
    stroke_soon: float = 0.1  # the same for a drive that was never later during the last envelope.window of motion [s]
    stroke_span: float = 0.3  # length of the two consecutive intervals that are compared for the acceleration [s]
    brake_margin: float = parameter(0.008, "m", 0.002, 10.0,
        "Motion of the count with the brake on that is a slip; a single step of half of it is a jump.")  # fmt: skip
    rest_speed: float = 0.02  # speed below which a braked drum counts as at rest [m/s]
    # share of the bounds on speed and travel within which the controller keeps its own orders [-]
    used_share: float = 0.9
    bound_time: float = 0.5  # time at a bound after which the envelope takes over [s]
    bound_window: float = 12.0  # time within which that counts [s]
    # time over which the envelope's own order, the MRU's raw rate about the requested move, fades [s]
    takeover_time: float = 10.0
    damping_time: float = 20.0  # time for which it goes on to damp the load by the load cell, before the brake [s]
    # speed, per metre of stretch of the nominal cable beyond its mean, with which it pays out to damp [1/s]
    damping_rate: float = 0.2
    fade_out_time: float = 45.0  # longest fade-out while the MRU is good [s]
    blind_time: float = 960.0  # longest fade-out without the MRU, in which the depth sensor damps the unit [s]
    unseen_time: float = 12.0  # longest compensation without a good MRU reading [s]
    stop_margin: float = 0.05  # speed about the ramp of a stop that is allowed [m/s]
    stop_time: float = 1.0  # time after the end of that ramp until the brake goes on [s]
    # distance of a requested move beyond that by the drum's count, or by the depth sensor [m]
    move_tolerance: float = 1.0
    # spread of the load cell, over that of the nominal cable with the winch locked, that is harm [-]
    harm_ratio: float = 1.3
    harm_margin: float = 0.01  # spread beyond that, over the static tension [-]
    # largest measured-to-nominal ratio, with the winch locked, that is accepted as the cable's own [-]
    harm_felt: float = 2.0
    # step of the load cell that is a jump, beyond the ship's motion, over the static tension [-]
    load_step: float = 0.15
    # tension over static below which the cable may snap [-]: for harm_time what a caught load makes is no jump
    load_taut: float = 0.5
    harm_time: float = 10.0  # time constant of those spreads, and time for which they must say so [s]
