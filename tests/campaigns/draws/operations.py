"""Operations under way: moves, an operator's speed, changes of the factor, a stop and a restart, a changing sea."""

from __future__ import annotations

from heave_bringup.closed_loop import ClosedLoop
from winch_controller_node.core.supervision.modes import ModeError

from tests.campaigns.draws.chance import Chance
from tests.campaigns.draws.deviation import BELIEF, Deviation, Nominal, Row
from tests.campaigns.draws.seas import highest
from tests.campaigns.promise import TROUBLE

FACTOR, SPEED = "factor", "speed"
"""Actions of an operator: another share of compensation, a speed of lowering [m/s]; NaN would be none, 0 ends it."""


def _lowering(chance: Chance, _: Nominal) -> Deviation:
    programme = f"{BELIEF}.programme"
    settings = {
        f"{programme}.move_times": [chance.between(90.0, 200.0)],
        f"{programme}.move_payouts": [chance.sign() * chance.between(2.0, 25.0)],
        f"{programme}.move_speeds": [chance.between(0.1, 0.5)],
    }
    return Deviation("", settings, {})


def _operator_speed(chance: Chance, _: Nominal) -> Deviation:
    start, speed = chance.between(90.0, 220.0), chance.sign() * chance.between(0.05, 0.4)
    return Deviation("", {}, {}, actions=((start, SPEED, speed), (start + chance.between(5.0, 40.0), SPEED, 0.0)))


def _factor_changes(chance: Chance, _: Nominal) -> Deviation:
    first = chance.between(80.0, 160.0)
    then = first + chance.between(20.0, 80.0)
    return Deviation("", {}, {}, actions=((first, FACTOR, chance.between(0.0, 0.9)), (then, FACTOR, 1.0)))


def _stop_and_restart(chance: Chance, _: Nominal) -> Deviation:
    stop = chance.between(90.0, 150.0)
    restart = stop + chance.between(35.0, 80.0)
    mode = chance.one_of(("standby", "stopped"))
    settings = {f"{BELIEF}.programme.mode_times": [stop, restart], f"{BELIEF}.programme.modes": [mode, "compensating"]}
    return Deviation("", settings, {}, excused=((stop, restart + TROUBLE),))


def _slewing_sea(chance: Chance, nominal: Nominal) -> Deviation:
    """Draw a later sea of another period, no steeper than there is."""
    period = nominal.period * chance.beside(0.65, 1.6, 0.15)
    height = min(nominal.height * chance.between(0.6, 1.3), highest(period))
    return Deviation("", _later(height, period, chance), {})


def _growing_sea(chance: Chance, nominal: Nominal) -> Deviation:
    """Draw a sea that grows into that of the scenario, which is up to six times as high."""
    settings = {
        **_later(nominal.height, nominal.period, chance),
        "wave_vessel.significant_wave_height": nominal.height / chance.between(1.5, 6.0),
    }
    return Deviation("", settings, {})


def _later(height: float, period: float, chance: Chance) -> dict[str, object]:
    values = {
        "significant_wave_height": height,
        "peak_period": period,
        "start": chance.between(40.0, 150.0),
        "duration": chance.between(60.0, 200.0),
    }
    return {f"wave_vessel.later_sea.{name}": value for name, value in values.items()}


CHANGING_SEAS = (
    Row("slewing sea", (), _slewing_sea, slot="sea"),
    Row("growing sea", (), _growing_sea, slot="sea"),
)

OPERATIONS = (
    Row("lowering", (), _lowering),
    Row("operator's speed", (), _operator_speed),
    Row("factor changes", (), _factor_changes),
    Row("stop and restart", (), _stop_and_restart),
    *CHANGING_SEAS,
)
"""Operations that may be under way besides; none is a reason to blame anything."""


class Operator:
    """Does in a running loop what an operator is drawn to do.

    Parameters
    ----------
    loop : that runs
    actions : time [s], what, value, in order of time
    tick_period : [s]

    Attributes
    ----------
    refused : what could not be done, in words
    """

    def __init__(self, loop: ClosedLoop, actions: tuple[tuple[float, str, float], ...], tick_period: float) -> None:
        self._loop, self._dt = loop, tick_period
        self._due = list(actions)
        self._speed = 0.0
        self.refused: list[str] = []

    def act(self, tick: int) -> None:
        """Do what is due after a `tick`; a speed is asked for again in every tick, as a joystick does."""
        controller = self._loop.controller
        try:
            while self._due and self._due[0][0] <= tick * self._dt:
                _, what, value = self._due.pop(0)
                if what == FACTOR:
                    controller.set_factor(value)
                else:
                    self._speed = value
            if self._speed:
                controller.operate(self._speed)
        except ModeError as error:
            self._speed = 0.0
            self.refused.append(f"{tick * self._dt:.0f} s: {error}")
