"""The same law again: the controller reads the record as it stands, and must give the orders of the record."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from heave_node.interface.alarm import Alarm
from winch_controller_node.beliefs.beliefs import Beliefs
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.whatif.signals.record import SensorRecord
from heave_studies.whatif.twin.core import Core

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


def observed_again(
    record: SensorRecord, parameters: WinchControllerParameters, on_tick: Callable[[int], None] | None = None
) -> Again:
    """Have a controller of the active `parameters` read a `record` as it stands.

    Parameters
    ----------
    record : of the sensors
    parameters : nominal, of the run
    on_tick : called with the number of ticks that are done
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
        if on_tick is not None:
            on_tick(index + 1)
    return Again(core.beliefs, parted, mode, was, tuple(alarms), tuple(core.refused))
