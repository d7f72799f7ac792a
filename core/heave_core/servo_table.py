"""The table of the servo: a drum under the set-points it was sent, limits included."""

from __future__ import annotations

from enum import IntEnum, IntFlag

from heave_core.rows import COUNTER, Row, structure

SERVO = structure(
    "Servo",
    "A speed servo behind a transport delay.",
    Row("lag", "s", "time constant"),
    Row("delay", "s", "from the start of a tick to the effect of its set-points"),
    Row("gain", "", "speed that it settles at over its set-point, paying out"),
    Row("deadband", "m/s", "of the set-point only what is beyond it counts"),
    Row("speed_out", "m/s", "limit of paying out"),
    Row("speed_in", "m/s", "limit of hauling in"),
    Row("acceleration_out", "m/s^2", "limit towards paying out"),
    Row("acceleration_in", "m/s^2", "limit towards hauling in"),
    Row("backlash", "m", "play of the encoder's gear"),
    Row("reach", "", "largest set-point that has an effect, over the limit of the speed"),
    Row("hauling", "", "gain of hauling in, over that of paying out"),
    Row("creep", "m/s", "speed at a set-point of 0"),
    Row("power", "W", "it turns no faster than this over the tension"),
)

SERVO_RUN = structure(
    "ServoRun",
    "A record of set-points, and how it is processed.",
    Row("sent", "", "set-points: more than ticks by the delay", COUNTER),
    Row("ticks", "", "at the end of the record, for which readings are made", COUNTER),
    Row("fitted", "", "readings that state payout and rate at the start", COUNTER),
    Row("start_steps", "", "Gauss-Newton steps to these", COUNTER),
    Row("tick_period", "s", "time of a tick"),
    Row("position_gain", "1/s", "of the servo's position loop; 0: none"),
    Row("position_step", "s", "step of the position loop; without one each piece of a tick is exact"),
    Row("edge", "", "part of a tick that counts as none"),
    Row("no_power_limit", "W", "power that no winch has"),
    Row("rate_step", "m/s", "step of the sensitivity to the rate at the start"),
    Row("weak_slope", "s", "effect of that rate on the payout that counts as none, as at the limit of the speed"),
)

SERVO_START = structure(
    "ServoStart",
    "A servo at the start of a record.",
    Row("payout", "m", "cable paid out"),
    Row("rate", "m/s", "speed, positive pays out"),
)

STRUCTURES = (SERVO, SERVO_RUN, SERVO_START)
"""In the order in which C++ needs them."""

RECORDS = STRUCTURES
"""What Python and C++ hold together."""

SIZES: dict[str, int] = {}
"""Sizes of arrays."""

ENUMERATIONS: tuple[type[IntEnum | IntFlag], ...] = ()
"""Names of numbers, and of bits."""
