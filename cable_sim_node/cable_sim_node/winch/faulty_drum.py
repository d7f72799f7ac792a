"""What a real winch does wrong between its set-points and its rope: the faults of drum, brake and hydraulic supply.

- `reverse` : the drum turns against the set-point, as with two phases or two hoses exchanged
- `brake_slip` : the brake is engaged, and says so, and the load pays out at the magnitude [m/s] all the same
- `brake_open` : the brake is energised open, and says so: at rest the load pays out at the magnitude [m/s]
  (neither where the drive holds it)
- `brake_shut` : the brake does not open, and says so: the drum stays where it is
- `creep` : the load pays out at the magnitude [m/s] besides what the drive does, as a motor leaks
- `low_pressure` : the drum reaches this share of its speed limit and no more

A slip and a creep need a load: a slack cable pays nothing out.
"""

from __future__ import annotations

from heave_node.interface.codes import WinchLimit
from heave_node.interface.faults import FaultSchedule

from cable_sim_node.winch.drives.interface import DriveCommand, DriveState
from cable_sim_node.winch.parameters import WinchParameters


class FaultyDrum:
    """Drum and brake between a drive and the rope.

    Parameters
    ----------
    parameters : the winch
    faults : of the winch

    Attributes
    ----------
    is_brake_engaged : as the brake's switch says
    """

    def __init__(self, parameters: WinchParameters, faults: FaultSchedule) -> None:
        self._speed_limit = parameters.speed_limit
        self._faults = faults
        self._slipped = 0.0
        self._is_limited = False
        self.is_brake_engaged = True

    def ordered(self, order: DriveCommand, time: float, payout: float) -> DriveCommand:
        """Return what the drive makes of an `order` at `time` [s], with the rope at a `payout` [m]."""
        if self._faults.is_empty:
            return order
        rate, place = order.payout_rate, order.payout - self._slipped
        if self._faults.is_active("reverse", time):
            rate, place = -rate, 2.0 * (payout - self._slipped) - place
        share = self._faults.newest("low_pressure", time)
        largest = self._speed_limit * (1.0 if share is None else share)
        self._is_limited = share is not None and abs(rate) > largest
        rate = min(max(rate, -largest), largest) if share is not None else rate
        return DriveCommand(rate, place, brake=order.brake or self._faults.is_active("brake_shut", time))

    def moved(
        self, state: DriveState, *, is_at_rest: bool, is_held: bool, time: float, duration: float, tension: float
    ) -> DriveState:
        """Return what the rope does of what the drive does.

        Parameters
        ----------
        state : of the drive, at the end
        is_at_rest : the winch holds: its brake is to be engaged
        is_held : by the drive as well
        time, duration : of the beginning, and of the step [s]
        tension : of the rope [N]
        """
        faults = self._faults
        self.is_brake_engaged = is_at_rest
        if faults.is_empty:
            return state
        is_open, is_shut = faults.is_active("brake_open", time), faults.is_active("brake_shut", time)
        self.is_brake_engaged = (is_at_rest or is_shut) and not is_open
        speed = 0.0
        if tension > 0.0:
            speed += faults.total("creep", time) * (not self.is_brake_engaged)
            speed += faults.total("brake_slip", time) * (self.is_brake_engaged and not is_held)
            speed += faults.total("brake_open", time) * (is_at_rest and not is_held)
        self._slipped += speed * duration
        return state._replace(
            payout=state.payout + self._slipped,
            payout_rate=state.payout_rate + speed,
            limits=state.limits | (WinchLimit.PRESSURE if self._is_limited else WinchLimit.NONE),
        )
