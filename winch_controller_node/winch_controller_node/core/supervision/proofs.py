"""Proofs by nominal values and raw readings alone, before the brake opens, in words: they are made in C++ (proofs.cpp).

- **MRU**: while the drum is braked, the load cell is compared with what a nominal load makes of the raw MRU,
  k (x0 - z), and the depth sensor with its z, by least squares with an offset, a trend and a free swing beside the
  slope. A slope of 1 says that the MRU reads what the load does; a negative one that it is reversed. On a long cable
  tension is not mass times acceleration: the waves are quicker than the load, and the sign is the other one.
- **Count**: it must go by the speed that the drive states with it, and by the drive's clock.
- **Brake**: wire that a braked drum pays out takes tension off at once, the stiffness of the cable times its length.

What the drum makes of its orders, and whether the load cell shows harm later, is the envelope's.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

import numpy as np
from heave_core.library import fill, library, new
from heave_core.proof_table import PROOF_DESIGN, PROOF_STATE, PROOF_WORK, ProofNews
from heave_node.interface.alarm import Alarm
from heave_node.interface.codes import WinchFault

from winch_controller_node.core.supervision.proof_design import COUNT_TIME, FALL_TIME, cable_at, proof_design
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import WinchReading
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.node_parameters import WinchControllerParameters

WITNESSES = ("load cell", "depth sensor", "load cell with depth sensor", "")
"""Sensors that the MRU is compared with, by their number in the core; -1: none."""


class Standing(Enum):
    """What is known of the MRU, in the order of the core's numbers."""

    OPEN = "not proved yet"
    QUIET = "too little motion to prove it by, and to do harm"
    PROVED = "proved"
    SCALED = "of another scale"
    REVERSED = "reversed"
    ALONE = "without a witness"


STANDINGS = tuple(Standing)
"""By the core's numbers."""

CLOSED = (Standing.SCALED, Standing.ALONE)
"""What an operator may consent to."""


class Fit(NamedTuple):
    """How a cross-check fits what it should read."""

    scale: float  # slope of the least squares [-]
    correlation: float  # of what is left of both without offset, trend and free swing [-]
    certainty: float  # slope over its standard error, which allows for the correlation in time of the residual [-]


class Proofs:
    """All proofs of a controller.

    Parameters
    ----------
    parameters : nominal ones
    cable : nominal, at their length
    tick_period : [s]

    Attributes
    ----------
    design, state : structured arrays of one element, on the memory that C++ reads and writes
    records : the same and what C++ works with, by the names of PROVING in `heave_core.law`
    """

    def __init__(self, parameters: WinchControllerParameters, cable: CableModel, tick_period: float) -> None:
        self._dt = tick_period
        self.design, self.state = new(PROOF_DESIGN), new(PROOF_STATE)
        self.records = {"proofs": self.design, "proof_state": self.state, "proof_work": new(PROOF_WORK)}
        self._flags = self.state.view(np.int32)[:8]
        self._row, core = self.state[0], library()
        self._begin, self._ask = core.heave_core_proofs_begin, core.heave_core_proofs_ask
        self._at = [one.ctypes.data for one in (self.design, self.state)]
        self._said = self._falling = ""
        self.take_nominal(parameters, cable)

    def take_nominal(self, parameters: WinchControllerParameters, cable: CableModel) -> None:
        """Prove by other nominal `parameters` and `cable` from now on."""
        self._cable, self._length = cable, parameters.length
        self._hang_on(cable, parameters.length)
        self._begin(*self._at)
        self._row["consent"] = parameters.entry.accept_unproved

    def _hang_on(self, cable: CableModel, length: float) -> None:
        """Prove with the unit on a `cable` of a `length` [m]."""
        fill(self.design[0], proof_design(cable, self._length, length, self._dt))

    @property
    def standing(self) -> Standing:
        """What is known of the MRU."""
        standing: Standing = STANDINGS[self._flags[0]]
        return standing

    @property
    def witness(self) -> str:
        """The sensor that it is known by; empty: none."""
        return WITNESSES[self._flags[2]]

    @property
    def fit(self) -> Fit:
        """How that fits."""
        row = self._row
        return Fit(float(row["scale"]), float(row["correlation"]), float(row["certainty"]))

    @property
    def consent(self) -> bool:
        """Tell whether an operator has compensation begin without a cross-check."""
        return bool(self._flags[3])

    def ask(self, *, consent: bool) -> None:
        """Take that an operator asks for a mode, with or without `consent` to begin without a cross-check."""
        self._ask(self._at[1], consent)
        self._falling = ""

    def left_of(self, obstacle: str) -> str:
        """Return what is left of an `obstacle` of the last tick, now that an operator asks: a proof is waited for."""
        is_mine = obstacle and obstacle == self._said
        return ("" if self.standing is Standing.OPEN else self._gate()) if is_mine else obstacle

    @property
    def gate(self) -> str:
        """Why compensation may not begin by the proofs of the last tick, in words; empty where it may."""
        self._said = self._falling or self._gate()
        return self._said

    def alarms(self, news: int, winch: WinchReading | None) -> tuple[Alarm, ...]:
        """Return the alarms of what is new, bits of `news`, with the report of the `winch`."""
        row, found = self._row, []
        if news & ProofNews.LOAD_FALLS:
            fall = float(row["fall"])
            way = fall / float(self.design["stiffness"][0])
            found.append(ALARMS.alarm("DRUM_NOT_HELD: hook load", fall=1e-3 * fall, time=FALL_TIME, way=way))
            self._falling = found[-1].brief
        moved = float(row["moved"])
        if news & ProofNews.DRUM_IS_HELD:
            found.append(ALARMS.alarm("DRUM_HELD_BY_DRIVE", moved=moved))
        if news & ProofNews.DRUM_IS_NOT_HELD:
            is_dead = winch is not None and winch.fault == WinchFault.EMERGENCY_STOP
            cause = "the emergency stop has taken the drive's power" if is_dead else "the drive does not hold it"
            found.append(ALARMS.alarm("DRUM_NOT_HELD: turns", moved=moved, rate=float(row["moved_rate"]), cause=cause))
        if news & ProofNews.COUNT_CONTRADICTS:
            error, way = float(row["found_error"]), float(row["way"])
            found.append(ALARMS.alarm("COUNT_SPEED_DISAGREE", error=error, way=way, time=COUNT_TIME))
        if news & ProofNews.MRU_CLOSED:
            found.append(self._alarm)
        if news & ProofNews.CABLE_IS_LONGER and winch is not None:
            length = max(self._length + winch.encoder_payout, 1.0)
            self._hang_on(cable_at(self._cable, length / self._length), length)
        return tuple(found)

    @property
    def _alarm(self) -> Alarm:
        """What keeps compensation from beginning."""
        fit, witness, standing = self.fit, self.witness, self.standing
        if standing is Standing.ALONE:
            agrees = f"its correlation with the {witness} is {fit.correlation:.2f}"
            return ALARMS.alarm(
                "MRU_UNPROVED: alone", why=agrees if witness else "neither load cell nor depth sensor reads"
            )
        code = "MRU_REVERSED" if standing is Standing.REVERSED else "MRU_UNPROVED: scale"
        numbers = {"scale": fit.scale, "correlation": fit.correlation, "certainty": abs(fit.certainty)}
        return ALARMS.alarm(code, witness=witness, **numbers)

    def _gate(self) -> str:
        """Return why compensation may not begin by what is known of the MRU."""
        standing = self.standing
        if standing is Standing.REVERSED or (standing in CLOSED and not self.consent):
            return self._alarm.brief
        return "proving the MRU by load cell and depth sensor" if standing is Standing.OPEN else ""
