"""Proofs before the brake opens, and motion under the brake, in whole loops of shipped scenarios."""

from dataclasses import replace

import pytest
from heave_bringup.closed_loop import COLUMNS, ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from heave_node.interface.alarm import Severity
from winch_controller_node.core.supervision.proofs import Standing
from winch_controller_node.interface.readings import Measurements

from tests.core_parts import Driven, Proofs
from tests.loops import TICK, Stepped, fault, settings_text

REVERSED = tuple(settings_text(fault("mru", "scale", 0.0, size=-1.0)))
NO_DEPTH = ("cable_sim.sensors.depth.fitted=false",)


class Run(Stepped):
    """A loop of a scenario with settings, and what its controller was given."""

    def __init__(self, scenario, *settings, seed=1):
        parameters = loop_parameters(load_scenario(scenario, settings=list(settings)))
        super().__init__(ClosedLoop(replace(parameters, seed=seed)))
        self.delivered = []
        step = self.loop.controller.step

        def kept(tick, measurements):
            self.delivered.append(measurements)
            return step(tick, measurements)

        self.loop.controller.step = kept

    def begins(self):
        """Return when compensation begins [s]; None: it does not."""
        return TICK * self.modes.index("compensating") if "compensating" in self.modes else None


def proved(delivered, scale, cable, parameters, witnesses):
    """Return what a locked winch's readings prove of an MRU that reads `scale` times what it does, by two windows."""
    windows = {first: Proofs(parameters, cable, TICK) for first in (400, 800)}
    for k, one in enumerate(delivered):
        mru = tuple(one._replace(heave=scale * one.heave, heave_rate=scale * one.heave_rate) for one in one.mru)
        scalar = {name: one.of(name) for name in witnesses}
        for first, proofs in windows.items():  # a load that does not hang is not compared, and moves on
            proofs.step(Measurements(mru, scalar), Driven(waits=False, hangs=k >= first))
    return [proofs.standing for proofs in windows.values()]


CASES = [
    pytest.param(scenario, 11 + j, (0.5, 1.0, 2.0, 3.0)[(i + j) % 4], marks=[pytest.mark.long] if j > 1 else [])
    for i, scenario in enumerate(("b2_calm_300", "b3_deep_900", "unit_1500", "b4_limit_900_tp10"))
    for j in range(5)
]
"""Two windows each: forty, of which the ordinary tests have sixteen."""


@pytest.mark.slow
@pytest.mark.parametrize(("scenario", "seed", "height"), CASES)
def test_a_sound_mru_is_proved_and_a_reversed_one_refused_by_either_witness(scenario, seed, height):
    """Of the tip's acceleration times the mass 20 of 40 windows would be reversed: those on 900 m.

    A window in which the sea is too quiet may leave it open, never the other way round; one of two in a row does not.
    """
    sea = (f"system.sea.significant_wave_height={height}", "wave_vessel.ramp=1.0")
    run = Run(scenario, *sea, "winch_controller.modes.start=standby", seed=seed).go(60.0)
    controller = run.loop.controller
    for witnesses in (("load_cell",), ("depth",)):
        for scale, standing in ((1.0, Standing.PROVED), (-1.0, Standing.REVERSED)):
            found = proved(run.delivered, scale, controller.design.cable, controller.parameters, witnesses)
            assert standing in found, witnesses
            assert set(found) <= {standing, Standing.OPEN}, witnesses


@pytest.mark.parametrize(("scenario", "begins"), [("b2_calm_300", 24.2), ("b10_real_mru_swell", 21.75)])
def test_the_proof_comes_within_the_time_in_which_compensation_waits_anyway(scenario, begins):
    """The times are those of the controller without proofs."""
    assert Run(scenario).go(begins + 1.0).begins() == pytest.approx(begins, abs=0.5 * TICK)


@pytest.mark.parametrize(
    ("scenario", "seed", "stiffness", "begins"),
    [
        ("b3_deep_900", 94432, 27.3e6, 35.0),  # slope 2.05 of the load cell, and 87 s
        ("b10_real_mru_swell", 98276, 9.26e6, None),  # 0.46
        ("unit_1500", 125790, None, 22.0),  # 5.96 at 9 s, when the heave was 6 mm rms
    ],
    ids=["stiff", "soft", "nominal"],
)
def test_a_sound_mru_is_not_refuted_by_another_cable_or_before_anything_moves(scenario, seed, stiffness, begins):
    """A cable of 0.6 times the stiffness is not proved either: an operator is asked after a minute."""
    settings = [f"cable_sim.cable.axial_stiffness={stiffness}"] if stiffness else []
    run = Run(scenario, *settings, seed=seed).go(begins or 50.0)
    assert "MRU_UNPROVED: scale" not in run.codes()
    assert (run.begins() is None) is (begins is None)


@pytest.mark.parametrize("settings", [REVERSED, REVERSED + NO_DEPTH], ids=["depth", "load cell alone"])
def test_a_reversed_mru_never_moves_the_load_whatever_an_operator_consents_to(settings):
    run = Run("b2_calm_300", *settings, "winch_controller.entry.accept_unproved=true").go(75.0)
    assert run.begins() is None
    assert "MRU_REVERSED" in run.codes()


def test_without_a_witness_compensation_waits_for_an_operators_consent():
    bare = (*NO_DEPTH, "cable_sim.sensors.load_cell.fitted=false")
    run = Run("b2_calm_300", *bare).go(40.0)
    assert run.begins() is None
    assert "MRU_UNPROVED: alone" in run.codes()
    run.loop.controller.ask_for_mode("compensating", consent=True)
    assert run.go(42.0).begins() == pytest.approx(40.0, abs=0.2)
    assert Run("b2_calm_300", *bare, "winch_controller.entry.accept_unproved=true").go(26.0).begins() is not None


def slipped(*settings, faults, seconds=2.5):
    """Return the alarms of a run in which winch faults begin, with the time and the way of the drum since the last."""
    run = Run("b2_calm_300", *settings)
    for kind, begin, magnitude in faults:
        run.go(begin)
        run.loop.winch.faults.inject(kind, start=run.time, magnitude=magnitude, duration=0.0)
    since, way, told = run.time, run.loop.winch.state.payout, []
    while run.time < since + seconds:
        outputs, row = run.loop.step()
        told += [(row[0] - since, row[COLUMNS.index("payout")] - way, alarm) for alarm in outputs.alarms]
    return told, run.loop.winch.state.payout - way


def test_a_brake_that_slips_in_standby_is_told_at_once_and_the_drive_holds_the_load():
    """0.5 m/s; without supervision 7.5 m in 15 s."""
    told, way = slipped("winch_controller.modes.start=standby", faults=[("brake_slip", 30.0, 0.5)])
    time, at, alarm = next(one for one in told if one[2].severity is Severity.CRITICAL)
    assert alarm.name == "DRUM_NOT_HELD: count"
    assert time < 0.3
    assert at <= 0.05 + 1e-6
    assert way < 0.1
    assert "DRUM_HELD_BY_DRIVE" in [one[2].name for one in told]


def test_a_brake_that_is_stuck_open_after_a_loss_of_power_is_told_at_once_and_that_nothing_holds_the_load():
    told, _ = slipped(faults=[("brake_open", 30.0, 0.5), ("emergency_stop", 40.0, 0.0)])
    time, _, alarm = next(one for one in told if one[2].severity is Severity.CRITICAL)
    assert alarm.name == "DRUM_NOT_HELD: count"
    assert time < 0.3 + 0.4  # of the stop itself, from 0.5 m/s at most
    (last,) = [one[2] for one in told if one[2].name == "DRUM_NOT_HELD: turns"]
    assert "emergency stop has taken the drive's power" in str(last)
