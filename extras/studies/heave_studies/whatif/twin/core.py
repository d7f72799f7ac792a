"""Controller and adviser over the ticks of a record; the same law again must give the orders of the record."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from heave_node.interface.alarm import Alarm
from winch_controller_node.adviser.component import Adviser
from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.core.component import WinchController
from winch_controller_node.core.supervision.modes import ModeError
from winch_controller_node.interface.readings import Measurements, Outputs, WinchOrder
from winch_controller_node.interface.requests import (
    DEPTH,
    DESIGN,
    FACTOR,
    HOLD,
    MODE,
    NO_SPEED,
    SPEED,
    Request,
)
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.whatif.signals.record import SensorRecord


class Core:
    """A controller that steps where that of a `record` did, and is given what came in time there.

    That is an operator's requests, and answers of an adviser.

    Parameters
    ----------
    record : whose ticks are stepped through
    parameters : nominal, of the controller
    has_adviser : it has one

    Attributes
    ----------
    beliefs : newest answer of the adviser that came in time
    refused : requests of an operator that it did not take, with their times, in words
    """

    def __init__(self, record: SensorRecord, parameters: WinchControllerParameters, *, has_adviser: bool) -> None:
        dt, self._record = record.tick_period, record
        self._controller = WinchController(parameters, tick_period=dt)
        self._controller.skip_programme((record.first - 1) * dt)
        self._adviser = Adviser(parameters, tick_period=dt) if has_adviser else None
        self._outputs: Outputs | None = None
        self.beliefs = Beliefs(asked=-1)
        self._speed: Request | None = None
        self.refused: list[str] = []

    def step(self, index: int, given: Measurements) -> tuple[Outputs, WinchOrder | None]:
        """Do the tick of an `index` with what is `given`; return what came of it, and the order, None in one left out.

        What came of a tick that is left out is that of the tick before, without its alarms.
        """
        tick = self._record.first + index
        self._obey(tick)
        if self._outputs is not None and self._record.orders[index] is None:
            self._controller.leave_out(tick)
            self._outputs = self._outputs._replace(alarms=(), observations=None)
            return self._outputs, None
        self._outputs = outputs = self._controller.step(tick, given)
        observed = outputs.observations
        if observed is not None and self._adviser is not None:
            beliefs = self._adviser.advise(observed)
            if observed.last not in self._record.late:
                self.beliefs = beliefs
                self._controller.take(beliefs)
        return outputs, outputs.order

    def _obey(self, tick: int) -> None:
        """Give the controller what an operator has requested of that of the record by a `tick`."""
        for request in self._record.requests.get(tick, ()):
            self._speed = request if request.kind == SPEED else None if request.kind == NO_SPEED else self._speed
            try:
                REPEATED[request.kind](self._controller, *request.values)
            except (ValueError, TypeError) as error:  # too few values, of a damaged record
                self.refused.append(f"{tick * self._record.tick_period:.1f} s: {request.words}: {error}")
        if self._speed is not None:
            # a joystick states its speed again and again; where it is not taken, that was said with the first one
            with contextlib.suppress(ModeError):
                REPEATED[SPEED](self._controller, *self._speed.values)


def _design(controller: WinchController, height: float, period: float, length: float) -> None:
    """Have a `controller` design again: significant wave `height` [m], peak `period` [s], cable `length` [m]."""
    old = controller.nominal
    sea = replace(old.sea, significant_wave_height=height, peak_period=period)
    controller.redesign(replace(old, sea=sea, length=length))


REPEATED: Mapping[str, Callable[..., Any]] = {
    MODE: WinchController.ask_for_mode,
    DEPTH: WinchController.move_to_depth,
    HOLD: WinchController.cancel_move,
    SPEED: WinchController.operate,
    NO_SPEED: WinchController.release_speed,
    FACTOR: WinchController.set_factor,
    DESIGN: _design,
}
"""How a request of each kind is given to a controller."""


REPRODUCED = 1e-9
"""Orders that differ by less are the same [m/s]."""


@dataclass(frozen=True)
class Again:
    """What the same controller makes of a record."""

    beliefs: Beliefs  # of the adviser at the end; nominal where there was none
    # time at which its orders or its mode are first other than those of the record [s]; infinite: never; NaN: not
    # asked, as the record's controller was another one
    parted: float
    mode: str = ""  # mode there
    was: str = ""  # mode in the record
    alarms: tuple[tuple[float, Alarm], ...] = field(default=(), repr=False)  # that it raised, with their times [s]
    refused: tuple[str, ...] = ()  # requests of the operator that it did not take, in words

    @property
    def is_same(self) -> bool:
        """Return whether every order was given again."""
        return math.isinf(self.parted)


def observed_again(record: SensorRecord, parameters: WinchControllerParameters) -> Again:
    """Have a controller of the active `parameters` read a `record` as it stands.

    Parameters
    ----------
    record : of the sensors
    parameters : nominal, of the run
    """
    core = Core(record, parameters, has_adviser=record.has_adviser)
    parted, mode, was = math.inf, "", ""
    alarms: list[tuple[float, Alarm]] = []
    for index, given in enumerate(record.measurements):
        outputs, order = core.step(index, given)
        alarms += [(float(record.time[index]), alarm) for alarm in outputs.alarms]
        ordered = record.orders[index]
        is_other = (order is not None and ordered is not None) and (
            order.brake != ordered.brake or not abs(order.payout_rate - ordered.payout_rate) <= REPRODUCED
        )
        if is_other and math.isinf(parted):
            parted, mode, was = float(record.time[index]), outputs.mode, record.modes[index]
    return Again(core.beliefs, parted, mode, was, tuple(alarms), tuple(core.refused))
