"""What figures of merit are made from: the motions of each, and where a run has those from."""

from __future__ import annotations

from collections.abc import Mapping

from heave_node.loads.strength import ROPE, WINCH_PULL

SOURCES = ("estimated", "measured", "true")
"""Sources of a motion, the least certain first."""
UNIT_HEAVE, FREE_HEAVE, TIP_HEAVE = "load heave", "load heave, winch locked", "boom-tip heave"
TOP_TENSION, PAYOUT, BASELINE = "top tension", "payout", "baseline"
_OF_TENSION = (
    *("tension_min_n", "tension_mean_n", "tension_max_n", "tension_sigma_n", "tension_ratio_min"),
    *("dynamic_amplification", "snaps", "top_tension_mean_n", "top_tension_amplitude_n"),
    *("tension_cycles_per_h", "tension_range_equivalent_n", ROPE, WINCH_PULL),
)
MOTIONS_OF: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("unit_sigma_m", "significant_residual_m", "max_abs_heave_m", "heave_p999_m"), (UNIT_HEAVE,)),
    **dict.fromkeys(("uncompensated_sigma_m", "uncompensated_max_abs_heave_m"), (FREE_HEAVE,)),
    **dict.fromkeys(("outlet_sigma_m", "outlet_efficiency"), (TIP_HEAVE, PAYOUT)),
    **dict.fromkeys(("boom_tip_sigma_m",), (TIP_HEAVE,)),
    **dict.fromkeys(("kappa", "unit_heave_amplitude_m"), (UNIT_HEAVE,)),
    "unit_efficiency": (UNIT_HEAVE, FREE_HEAVE),
    **dict.fromkeys(("baseline_efficiency", "baseline_outlet_efficiency"), (BASELINE,)),
    "unit_heave_phase_deg": (UNIT_HEAVE, TIP_HEAVE),
    **dict.fromkeys(_OF_TENSION, (TOP_TENSION,)),
    **dict.fromkeys(("winch_speed_max_mps", "winch_acceleration_max_mps2"), (PAYOUT,)),
}
"""Motions that figures are made from, by key."""


def source_of(key: str, sources: Mapping[str, str]) -> str:
    """Return what figure `key` is made from, by the `sources` of a run's motions: the least certain; "" for others."""
    found = [sources[motion] for motion in MOTIONS_OF.get(key, ()) if motion in sources]
    return next((source for source in SOURCES if source in found), "")
