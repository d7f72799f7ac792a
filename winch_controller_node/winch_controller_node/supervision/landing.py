"""Whether a unit that is lowered has landed, and whether one that is lifted off hangs again."""

from __future__ import annotations

import math

from winch_controller_node.estimation.observation import Observer
from winch_controller_node.model.estimator import KalmanEstimator
from winch_controller_node.motion.mean_motion import RETURN_SPEED
from winch_controller_node.parameters.laws import TensionLawParameters
from winch_controller_node.supervision.modes import Mode, ModeOutput

STANDING_SURPRISE = 3.0
"""Standard deviations by which the depth sensor sees a landed unit above a hanging one, at least."""


class LandingWatch:
    """Knows where the unit is between hanging and standing, by its weight and by what the depth sensor sees.

    Parameters
    ----------
    observer : gates and depth readings

    Attributes
    ----------
    has_landed : the unit stands on the seabed; is_lifting : and is being lifted off
    """

    def __init__(self, observer: Observer) -> None:
        self._observer = observer
        self.has_landed = False
        self.is_lifting = False
        self._surprise = 0.0

    def note_depth(self, estimator: KalmanEstimator) -> None:
        """Note how far above the expected depth the newest reading of the tick was, if one came."""
        depth = estimator.innovations.get("unit_heave")
        if depth is not None and math.isfinite(depth.nis):
            self._surprise = depth.value / depth.sigma

    def touches_down(
        self,
        weight_share: float,
        mode: ModeOutput,
        lowering_rate: float,
        parameters: TensionLawParameters,
        estimator: KalmanEstimator,
    ) -> bool:
        """Tell whether a hanging unit has landed.

        Parameters
        ----------
        weight_share : share of the unit's weight that the cable carries, as measured
        mode : of the tick
        lowering_rate : of the mean payout [m/s]
        parameters : share at which it has
        estimator : whose measurements say whether there is a depth sensor
        """
        if self.has_landed:
            return False
        lowering = mode.mode is Mode.COMPENSATING and lowering_rate > RETURN_SPEED
        is_relieved = lowering and mode.authority > 0.5 and weight_share < parameters.touchdown_ratio
        return is_relieved and self._stands(lowering_rate, estimator)

    def hangs(self, weight_share: float, parameters: TensionLawParameters) -> bool:
        """Tell whether a unit that is being lifted off hangs."""
        return self.is_lifting and weight_share > parameters.lift_off_ratio

    def land(self) -> None:
        """Take the unit to stand on the seabed: sensors on it say nothing of a hanging one."""
        self.has_landed, self.is_lifting = True, False
        self._observer.uses_unit = False

    def hang(self) -> None:
        """Take the unit to hang."""
        self.has_landed, self.is_lifting = False, False
        self._observer.uses_unit = True

    def _stands(self, lowering_rate: float, estimator: KalmanEstimator) -> bool:
        """Tell whether the depth sensor sees the unit stand, above where a hanging one would have fallen.

        A unit that swings unloads the cable too, but falls as the model says, and falls in any case. Without a depth
        sensor the tension alone tells.
        """
        if "unit_heave" not in estimator.measurements or self._observer.gates["depth"].reason == "stale":
            return True
        return self._surprise > STANDING_SURPRISE and self._observer.standing.stands(lowering_rate)
