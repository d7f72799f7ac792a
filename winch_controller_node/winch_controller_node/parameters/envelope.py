"""Parameters of the envelope, the last bound on every order: margins and times. Where they come from is in its page."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.parameters import parameter


@dataclass(frozen=True)
class EnvelopeParameters:
    """The envelope: what speed and travel of the drum the ship's own motion explains, and what ends in the brake."""

    active: bool = parameter(True,
        description="Bound every order; false lets all orders pass, for trials in simulation only.")  # fmt: skip
    window: float = parameter(60.0, "s", 5.0, 600.0, "Time over which the boom tip's motion is watched.")
    rate_factor: float = parameter(1.5, "", 1.0, 10.0,
        "Largest speed about the requested move over the largest rate of the boom tip in the window.")  # fmt: skip
    rate_margin: float = parameter(0.25, "m/s", 0.0, 10.0, "Speed that is allowed beyond that.")
    travel_factor: float = parameter(1.5, "", 1.0, 10.0,
        "Largest travel about the requested move over the largest heave of the boom tip in the window.")  # fmt: skip
    travel_margin: float = parameter(0.3, "m", 0.0, 100.0, "Travel that is allowed beyond that.")
    travel_time: float = parameter(60.0, "s", 1.0, 3600.0, "Time constant with which travel is forgotten.")
    early_factor: float = parameter(2.5, "", 1.0, 10.0, "Factor on both bounds while the window is empty.")
    lost_factor: float = parameter(0.8, "", 0.1, 1.0,
        "Factor on both bounds while the drum's count or the MRU is lost.")  # fmt: skip
    largest_heave: float = parameter(15.0, "m", 0.1, 50.0, "Heave beyond which an MRU reading is implausible.")
    largest_rate: float = parameter(6.0, "m/s", 0.1, 50.0, "Rate beyond which an MRU reading is implausible.")
    largest_acceleration: float = parameter(20.0, "m/s^2", 1.0, 1000.0,
        "Change of the MRU's rate beyond which two readings in a row do not belong together.")  # fmt: skip
    heave_step: float = parameter(0.2, "m", 0.01, 10.0,
        "Step of the MRU's heave, beyond what its rate explains, that is a jump and is taken off.")  # fmt: skip
    mru_time: float = parameter(2.0, "s", 0.1, 60.0,
        "Time without a good reading after which the MRU is lost; above modes.coast_time.")  # fmt: skip
    frozen_readings: int = parameter(10, "", 2, 10_000, "Equal MRU readings in a row that count as frozen.")
    count_time: float = parameter(0.5, "s", 0.05, 60.0,
        "Time without a good reading after which the drum's count is lost.")  # fmt: skip
    count_step: float = parameter(0.05, "m", 1e-3, 10.0,
        "Step of the count, beyond the drum's largest speed, that is a jump and is taken off.")  # fmt: skip
    frozen_travel: float = parameter(0.1, "m", 1e-3, 10.0,
        "Travel that was sent without a step of the count, after which the count is frozen.")  # fmt: skip
    frozen_time: float = parameter(0.4, "s", 0.05, 60.0, "Time that this takes at least.")
    drum_margin: float = parameter(0.1, "m", 0.01, 10.0,
        "Distance of the count from the nominal drum at which the brake goes on.")  # fmt: skip
    drum_share: float = parameter(0.4, "", 0.0, 5.0,
        "Fraction of the travel of the last drum_time that is added to that distance.")  # fmt: skip
    drum_time: float = parameter(1.0, "s", 0.1, 60.0, "Time constant with which that distance is forgotten.")
    stroke_factor: float = parameter(1.5, "", 1.0, 10.0,
        "Speed and acceleration of the count, over the largest recently commanded, that are allowed.")  # fmt: skip
    stroke_margin: float = parameter(0.02, "m", 0.005, 10.0,
        "Travel allowed beyond that, in addition to two steps of the count.")  # fmt: skip
    stroke_gain: float = parameter(0.7, "", 0.1, 1.0,
        "Weight of the check of acceleration relative to that of speed: a drive may overshoot.")  # fmt: skip
    stroke_late: float = parameter(0.6, "s", 0.0, 10.0, "Additional lag that a drive may have beyond the stated one.")
    stroke_soon: float = parameter(0.1, "s", 0.0, 10.0,
        "The same for a drive that was never later during the last envelope.window of motion.")  # fmt: skip
    stroke_span: float = parameter(0.3, "s", 0.05, 10.0,
        "Length of the two consecutive intervals that are compared for the acceleration.")  # fmt: skip
    brake_margin: float = parameter(0.025, "m", 0.002, 10.0,
        "Motion of the count under the brake that is a slip; a single step of half of it is a jump.")  # fmt: skip
    rest_speed: float = parameter(0.02, "m/s", 1e-4, 1.0, "Speed below which a braked drum counts as at rest.")
    used_share: float = parameter(0.9, "", 0.1, 1.0,
        "Share of the bounds on speed and travel within which the controller keeps its own orders.")  # fmt: skip
    bound_time: float = parameter(0.5, "s", 0.05, 60.0, "Time at a bound after which the envelope takes over.")
    bound_window: float = parameter(12.0, "s", 1.0, 600.0, "Time within which that counts.")
    takeover_time: float = parameter(10.0, "s", 0.5, 600.0,
        "Time over which the envelope's own order, the MRU's raw rate about the requested move, fades.")  # fmt: skip
    damping_time: float = parameter(20.0, "s", 0.0, 600.0,
        "Time for which it goes on to damp the load by the load cell, before the brake.")  # fmt: skip
    damping_rate: float = parameter(0.2, "1/s", 0.0, 1.0,
        "Speed, per metre of stretch of the nominal cable beyond its mean, with which it pays out to damp.",
    )  # fmt: skip
    fade_out_time: float = parameter(45.0, "s", 1.0, 3600.0, "Longest fade-out while the MRU is good.")
    blind_time: float = parameter(960.0, "s", 1.0, 36_000.0,
        "Longest fade-out without the MRU, in which the depth sensor damps the unit.")  # fmt: skip
    unseen_time: float = parameter(12.0, "s", 0.5, 3600.0, "Longest compensation without a good MRU reading.")
    stop_margin: float = parameter(0.05, "m/s", 0.0, 1.0, "Speed about the ramp of a stop that is allowed.")
    stop_time: float = parameter(1.0, "s", 0.0, 60.0, "Time after the end of that ramp until the brake goes on.")
    move_tolerance: float = parameter(1.0, "m", 0.0, 100.0,
        "Distance of a requested move beyond that by the drum's count, or by the depth sensor.")  # fmt: skip
    harm_ratio: float = parameter(1.3, "", 1.0, 10.0,
        "Spread of the load cell, over that of the nominal cable with the winch locked, that is harm.")  # fmt: skip
    harm_margin: float = parameter(0.01, "", 0.0, 1.0, "Spread beyond that, over the static tension.")
    harm_felt: float = parameter(2.0, "", 1.0, 10.0,
        "Largest measured-to-nominal ratio, with the winch locked, that is accepted as the cable's own.")  # fmt: skip
    load_step: float = parameter(0.15, "", 0.02, 10.0,
        "Step of the load cell that is a jump, beyond the ship's motion, over the static tension.")  # fmt: skip
    load_taut: float = parameter(0.5, "", 0.0, 1.0,
        "Tension over static below which the cable may snap: then no jump is detected for harm_time.")  # fmt: skip
    harm_time: float = parameter(10.0, "s", 1.0, 600.0,
        "Time constant of those spreads, and time for which they must say so.")  # fmt: skip
