"""What the last minute of orders was: within it a fade-out stays, whatever is estimated."""

from __future__ import annotations

from winch_controller_node.motion.trajectory import approach_speed

MINUTE = 60.0
"""Time over which speeds and travel are remembered [s]: some waves."""

MORE, ROOM = 1.2, 0.1
"""Travel that a fade-out may take: so many times the largest of the last minute, and so much more [m]."""

EASING, QUICKER, MORE_ACCELERATION = 2.0, 1.5, 0.3
"""Time after a change of what is assumed in which the order makes no larger step [s]: so many times the largest of the
last minute, and so much more [m/s^2]."""


class OrderMinute:
    """Speeds that were ordered and the travel that they make, over a minute: e' = v - e / MINUTE.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._speed = self._travel = 0.0
        self._largest_speed = self._largest_travel = 0.0
        self._fading, self._longest = 0.0, 1.0
        self._sent = self._largest_step = self._easing = 0.0

    def note(self, speed: float, sent: float) -> None:
        """Take in the `speed` that is ordered in a tick, and the set-point `sent` for it [m/s]."""
        kept = 1.0 - self._dt / MINUTE
        step, self._sent = abs(sent - self._sent), sent
        if self._easing == 0.0:
            self._largest_step = max(step, kept * self._largest_step)
        self._easing = max(self._easing - self._dt, 0.0)
        self._speed, self._travel = speed, kept * self._travel + speed * self._dt
        if self._fading == 0.0:
            self._largest_speed = max(abs(speed), kept * self._largest_speed)
            self._largest_travel = max(abs(self._travel), kept * self._largest_travel)

    def ease(self) -> None:
        """Let the order make no step for a time: something else is assumed."""
        self._easing = EASING

    def beyond(self, sent: float) -> float:
        """Return by how much a set-point `sent` is beyond the step that is allowed [m/s]; 0: it is not, or any is."""
        if self._easing == 0.0:
            return 0.0
        allowed = QUICKER * self._largest_step + MORE_ACCELERATION * self._dt
        step = sent - self._sent
        return step - min(max(step, -allowed), allowed)

    def restart(self) -> None:
        """No fade-out is under way."""
        self._fading = 0.0

    def fade(self, longest: float, *, is_held: bool) -> None:
        """Count a tick of a fade-out of at most `longest` [s]; not where it `is_held` until a sensor is back."""
        self._fading = min(self._fading + (0.0 if is_held and self._fading > 0.0 else self._dt), longest)
        self._longest = longest

    def bounds(self, acceleration: float, lag: float, step: float) -> tuple[float, float]:
        """Return the least and the largest speed of a tick of a fade-out [m/s].

        None is larger than in the minute before, and ever less is allowed; the way ends where it then ended. Where the
        last speed is outside, it comes back step by step.

        Parameters
        ----------
        acceleration : with which the winch brakes [m/s^2]
        lag : of its servo [s]
        step : by which it comes back in a tick [m/s]
        """
        largest = self._largest_speed * (1.0 - self._fading / self._longest)
        end = MORE * self._largest_travel + ROOM
        up, down = (
            min(largest, approach_speed(max(end - sign * self._travel, 0.0), acceleration, lag)) for sign in (1.0, -1.0)
        )
        return min(-down, self._speed + step), max(up, self._speed - step)
