"""The boom tip from tension and drum: what a reading is, and the margins of the loop, against the wave equation."""

import math
from dataclasses import replace

import numpy as np
import pytest
from heave_core.law import put
from heave_core.law_table import TENSION_ALONE
from heave_core.library import new
from winch_controller_node.design.design import design_controller
from winch_controller_node.laws.parts.tip_by_tension import (
    WAVE_KEPT,
    TensionAlone,
    TensionRecord,
    TipByTension,
    mean_weights,
    wire_loop,
)
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.node_parameters import WinchControllerParameters

from tests.core_parts import NUMBER, lead_alone, note_tension, part

DT = 0.05


@pytest.fixture(scope="module")
def design():
    return design_controller(WinchControllerParameters(), tick_period=DT)


def alone(design, round_trip, *, cable=None, time_constant=2.0):
    """Return what leads by the tension alone on a wire of a `round_trip` [s]."""
    return TensionAlone(design.model, cable or design.cable, design.parameters.winch, round_trip, time_constant)


class StandingWire:
    """The wave equation of a wire that stands, by d'Alembert, in twentieths of a tick.

    T(t) = r T(t - t1) + Z (v(t) + r v(t - t1)) for the speed v at which it is pulled, Z = k t1/2.
    """

    SUBSTEPS = 20

    def __init__(self, wave_time, stiffness):
        self.late = round(wave_time * self.SUBSTEPS / DT)
        self.impedance = 0.5 * stiffness * wave_time
        self.tension, self.speed, self.newest = np.zeros(self.late), np.zeros(self.late), 0.0

    def pull(self, speed):
        """Return the tension after a tick at whose end it is pulled at a `speed` [m/s], which changes evenly."""
        n = self.SUBSTEPS
        speeds = np.linspace(self.newest, speed, n + 1)[1:]
        self.newest = speed
        tension = WAVE_KEPT * self.tension[:n] + self.impedance * (speeds + WAVE_KEPT * self.speed[:n])
        self.tension = np.append(self.tension[n:], tension)
        self.speed = np.append(self.speed[n:], speeds)
        return float(tension[-1])


@pytest.mark.parametrize(
    ("window", "mean"), [(0.1, 38.5), (0.125, (39 + 38 + 0.5 * 37) / 2.5), (5.0, np.mean(np.arange(19, 40)))]
)
def test_the_mean_over_a_round_trip_averages_and_fills_the_window_by_parts_of_a_tick(window, mean):
    """A second and the newest tick are kept, and two seconds have passed; the payout is that at both ends of 0.2 s."""
    record, core = TensionRecord(1.0, tick_period=DT), new(TENSION_ALONE)
    for number in range(40):
        note_tension(record, float(number), 10.0 * number)
    weights = mean_weights(window / DT)
    put(core, {"window": len(weights), "weights": weights, "trip": 4, "stiffness": 2.0})
    read = part("read_tip", result=NUMBER)(core, record.record)
    assert read == pytest.approx(mean / 2.0 + 10.0 * 37.0)


def test_a_round_trip_takes_the_time_of_sound_in_the_wire(design):
    cable = design.parameters.cable
    speed = math.sqrt(cable.axial_stiffness / cable.mass_per_length)
    assert design.wave_round_trip(20.0) == pytest.approx(2.0 * (design.parameters.length + 20.0) / speed)


def test_the_rate_of_the_boom_tip_is_told_whatever_the_winch_does(design):
    """A boom tip of one frequency; a drum that stands, or moves at another and at the wire's first mode."""
    round_trip, omega = 0.8, 0.6
    time = DT * np.arange(2400)
    tip_rate = 0.3 * np.cos(omega * time)
    mode = 2.0 * math.pi / round_trip
    loop = wire_loop(design.cable, design.parameters.winch, round_trip, DT)

    def told(share):
        """Return estimated rates and tensions, from 60 s on, with a share of the drum's motion."""
        payout = share * (0.3 * np.sin(1.1 * time) + 0.02 * np.sin(mode * time))
        payout_rate = share * (0.33 * np.cos(1.1 * time) + 0.02 * mode * np.cos(mode * time))
        wire = StandingWire(round_trip, design.cable.stiffness)
        follower = TipByTension(design.model, loop, 0.5)
        follower.window, core = round_trip, new(TENSION_ALONE)
        follower.tell(core)
        record = TensionRecord(1.0, tick_period=DT)
        rates, tensions = [], []
        for pulled, out in zip(tip_rate - payout_rate, payout, strict=True):
            tensions.append(wire.pull(pulled))
            note_tension(record, tensions[-1], out)
            rates.append(part("follow_tip", result=NUMBER)(record.record, core))
        return np.array(rates)[time > 60.0], np.array(tensions)[time > 60.0]

    still, quiet = told(0.0)
    moved, loud = told(1.0)
    assert np.std(loud) > 2.0 * np.std(quiet)
    assert np.std(moved - still) < 0.1 * np.std(still)
    wanted = 0.3 * np.cos(omega * (time + loop.delay + loop.lag))[time > 60.0]
    assert np.std(still - wanted) < 0.5 * np.std(wanted)


@pytest.mark.parametrize("round_trip", [0.2, 0.8, 1.55, 2.6])
@pytest.mark.parametrize("wave_share", [0.95, 1.0, 1.05])
def test_the_loop_at_twice_its_gain_does_not_ring_on_a_wire_that_stands(design, round_trip, wave_share):
    """What a boom tip that rises by 0.1 m within 1 s leaves in wire and drum dies away."""
    winch, lead = design.parameters.winch, alone(design, round_trip)
    wire = StandingWire(wave_share * round_trip, design.cable.stiffness / wave_share**2)
    record = TensionRecord(1.05 * round_trip, tick_period=DT)
    commands = [0.0] * round(winch.command_delay / DT)
    settling = math.exp(-DT / winch.time_constant)
    payout = rate = 0.0
    swing = []
    for tick in range(2400):
        tip_rate = 0.1 if 20 < tick <= 40 else 0.0
        swing.append(wire.pull(tip_rate - rate))
        note_tension(record, swing[-1], payout)
        asked = lead_alone(lead, record, 0.0, unit_stands=True)
        commands.append(2.0 * (asked.tip + asked.correction))
        command = commands.pop(0)
        before, rate = rate, command + (rate - command) * settling
        payout += 0.5 * DT * (before + rate)
    assert np.std(swing[-600:]) < np.std(swing[600:1200])


def test_the_correction_is_slow_enough_above_a_unit_that_hangs(design):
    """Lightly damped and slow to hear of, the unit's resonance a/(b T) rules; else what is real above it."""
    light = replace(design.cable, a=1.0, b=0.1)
    assert alone(design, 6.0, cable=light).hanging == pytest.approx(2.0 * 1.0 / 0.1)
    quarter = math.pi / (2.0 * (0.5 * 0.8 + 0.2 + 0.5 * DT + 0.15))
    heavy = CableModel(10.0, 0.1, design.cable.stiffness)
    largest = 10.0 * quarter / (10.0 * quarter**2 - 1.0)
    assert alone(design, 0.8, cable=heavy, time_constant=0.1).hanging == pytest.approx(2.0 * largest)
