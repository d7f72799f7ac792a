"""Rope on a drum: layers, falls, and what the drum's radius does to payout."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cable_sim_node.winch.drives.interface import DriveCommand
from heave_drives.electric import ElectricDrive
from heave_drives.kernels.spool import make_spool
from heave_drives.parameters import ElectricDriveParameters, MotionParameters, SpoolParameters

LAYERED = SpoolParameters(drum_radius=0.4, rope_diameter=0.04, turns_per_layer=10, rope_at_zero=100.0, falls=2)


def test_layers_hold_the_rope_that_their_radii_say() -> None:
    spool = make_spool(LAYERED, -10.0, 50.0)
    # centre line of the first layer at drum_radius + d/2, each next one sqrt(3)/2 d further out, ten turns in each
    radii = 0.42 + 0.04 * math.sqrt(3.0) / 2.0 * np.arange(spool.radius.size)
    np.testing.assert_allclose(spool.radius, radii)
    np.testing.assert_allclose(spool.full, np.cumsum(20.0 * math.pi * radii))
    assert spool.full[-1] >= 120.0 > spool.full[-2]  # 100 m and two falls of 10 m more


def test_a_drum_without_rope_enough_is_refused() -> None:
    with pytest.raises(ValueError, match="payout_maximum = 60 m with 2 falls needs 120 m of rope"):
        make_spool(LAYERED, -10.0, 60.0)


def test_payout_per_turn_follows_the_layers_from_full_to_empty() -> None:
    motion = MotionParameters(payout_minimum=-1.0, payout_maximum=50.0, speed_limit=3.0)
    drive = ElectricDrive(ElectricDriveParameters(motion=motion, spool=LAYERED, gear_ratio=10.0), tension=5e3)
    speeds, payout = [], []
    for _ in range(480):
        payout.append(drive.step(DriveCommand(2.0), 0.05, 5e3).payout)
        speeds.append(drive.instruments()["motor_speed_radps"] / 10.0)
    turned = np.cumsum(0.025 * (np.array(speeds)[1:] + np.array(speeds)[:-1]))
    payout = payout[1:]
    rope = 100.0 - 2.0 * np.array(payout)
    arms = np.diff(payout) / np.diff(turned)  # metres of payout per radian of the drum
    spool = make_spool(LAYERED, -1.0, 50.0)
    for layer, radius in enumerate(spool.radius):
        low = spool.full[layer - 1] if layer else 0.0
        inside = (rope[1:] > low + 0.3) & (rope[:-1] < spool.full[layer] - 2.0 * math.pi * radius - 0.3)
        if np.any(inside):
            np.testing.assert_allclose(arms[inside][1:-1], radius / 2.0, rtol=2e-3)
    assert payout[-1] > 45.0
    assert np.all(np.diff(arms[40:]) < 1e-4)  # never an arm that grows while the rope leaves
