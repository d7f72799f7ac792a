"""The load while the winch stands: whether the cable carries it, and whether payout and depth sensor agree on it."""

from __future__ import annotations

from heave_node.interface.alarm import Alarm

from winch_controller_node.core.estimation.loop_tick import TENSION_MEMORY, LoopTick
from winch_controller_node.core.supervision.landing import HangingLoad, Landing
from winch_controller_node.core.supervision.watch.load_watch import Episode
from winch_controller_node.core.supervision.watch.payout_watch import PayoutWatch
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.alarms import ALARMS


class StandingLoad:
    """Weighs the load under the brake.

    Parameters
    ----------
    landing : that weighs it
    design : the active one

    Attributes
    ----------
    more : cable at payout 0 beyond that of the design [m]
    """

    def __init__(self, landing: Landing, design: ControllerDesign) -> None:
        self._landing, self._dt = landing, design.tick_period
        self._unloaded, self._payout_watch = Episode(self._dt), PayoutWatch(design)
        self._unweighed_time = self._wait = 0.0
        self.take_design(design)

    def take_design(self, design: ControllerDesign) -> None:
        """Refer to another `design` from now on."""
        self._payout_watch.take_design(design)
        self.more = design.parameters.length - design.length

    def update(
        self, tick: LoopTick, mean_payout: float, load: HangingLoad, *, brake: bool, is_wanted: bool
    ) -> tuple[Alarm, ...]:
        """Take in a tick; return what is new: the load does not hang, or elsewhere.

        A landing that was seen is known better than that: the brake may since have let the sea pull at the unit. What
        a load cell has said is kept for a while without it.

        Parameters
        ----------
        tick : what is known at it
        mean_payout : [m]
        load : that would hang
        brake : is on
        is_wanted : compensation is to begin
        """
        landing = self._landing
        is_lost = "load_cell" in tick.lost
        self._unweighed_time = self._unweighed_time + self._dt if is_lost else 0.0
        if self._unweighed_time > TENSION_MEMORY:
            landing.forget_weight()
        is_weighed = brake and not (landing.unit_stands or is_lost)
        self._wait = landing.weigh(tick.mean_tension, mean_payout + self.more) if is_weighed else 0.0
        alarms = (self._alarm,) if self._unloaded.begins(landing.is_unloaded and is_wanted) else ()
        is_known = brake and landing.hangs and "encoder" not in tick.lost
        return alarms + self._payout_watch.update(
            tick.depths, mean_payout, load.swing_time, is_known=is_known and tick.sees_landing
        )

    @property
    def _alarm(self) -> Alarm:
        return ALARMS.alarm("UNIT_NOT_SUSPENDED", percent=100.0 * max(self._landing.share, 0.0))

    @property
    def gate(self) -> str:
        """Why compensation may not begin, in words; empty where it may."""
        if self._landing.is_unloaded:
            return self._alarm.brief
        if self._wait > 0.0:
            return f"averaging the tension for {self._wait:.0f} s more, to know whether the load hangs"
        return ""
