"""Between quality of service as a bag stores it and rclpy's profiles: what to ask for when recording, what to
offer when playing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

from heave_bags.mcap.ros.qos import INFINITE, OfferedQos

RECORDER_DEPTH = 5000
"""Messages kept for a recorder that is held up: half a second at 10,000 a second."""
PLAYER_DEPTH = 100
"""Messages that a player keeps at least for a slow subscriber."""


def offered_qos(profile: QoSProfile) -> OfferedQos:
    """Return a publisher's offer, its `profile`, as a bag stores it."""
    latched = profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    best_effort = profile.reliability == ReliabilityPolicy.BEST_EFFORT
    manual = profile.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC
    return OfferedQos(
        history="keep_all" if profile.history == HistoryPolicy.KEEP_ALL else "keep_last",
        depth=profile.depth or OfferedQos.depth,
        reliability="best_effort" if best_effort else "reliable",
        durability="transient_local" if latched else "volatile",
        deadline=_nanoseconds(profile.deadline),
        lifespan=_nanoseconds(profile.lifespan),
        liveliness="manual_by_topic" if manual else "automatic",
        liveliness_lease_duration=_nanoseconds(profile.liveliness_lease_duration),
    )


def _nanoseconds(duration: Any) -> int:
    return duration.nanoseconds if 0 < duration.nanoseconds < INFINITE else INFINITE


def request_for(offers: Sequence[OfferedQos]) -> QoSProfile:
    """Return the strictest request that all `offers` meet: reliable and latched only where every publisher is."""
    reliable = all(offer.reliability == "reliable" for offer in offers)
    latched = bool(offers) and all(offer.durability == "transient_local" for offer in offers)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=RECORDER_DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def offer_like(recorded: Sequence[OfferedQos]) -> QoSProfile:
    """Return an offer that satisfies every subscriber that one of the `recorded` offers would have satisfied."""
    offers = recorded or (OfferedQos(),)
    reliable = any(offer.reliability == "reliable" for offer in offers)
    latched = any(offer.durability == "transient_local" for offer in offers)
    depth = max(offer.depth for offer in offers)
    profile = QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth if latched else max(depth, PLAYER_DEPTH),
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
    deadline = min(offer.deadline for offer in offers)
    if deadline < INFINITE:
        profile.deadline = Duration(nanoseconds=deadline)
    lease = min(offer.liveliness_lease_duration for offer in offers)
    if lease < INFINITE:
        profile.liveliness_lease_duration = Duration(nanoseconds=lease)
    return profile
