"""The table of the Kalman filter: model and gates, what a tick changes, readings, and what they said.

A pass is one linear filter over a record, in many versions of the record at once.
"""

from __future__ import annotations

from heave_core.rows import COUNTER, Row, Size, structure

STATES = Size("STATES", 96)
"""Most states of a model. Matrices lie packed in their arrays, row by row, so that a small one is small in a cache."""

MEASUREMENTS = Size("MEASUREMENTS", 16)
"""Most measurements of a model."""

PAST = Size("PAST", 1 << 19)
"""Numbers for the ticks that are kept, n (n + 3)/2 of each for n states: 200 ticks of 70 states."""

PAST_TICKS = Size("PAST_TICKS", 1024)
"""Most ticks that are kept."""

USED = Size("USED", 4096)
"""Readings used that are kept, of all ticks."""

DRAG = structure(
    "UnitDrag",
    "Quadratic drag of the unit, beyond the linear damping of the model.",
    Row("rate", "", "index of the unit's heave rate in the state"),
    Row("inertia", "s^2", "a of the cable model"),
    Row("damping", "s", "linear damping that the model has"),
    Row("quadratic", "s^2/m", "damping over speed; 0: no drag"),
    Row("tick_period", "s", "time of a step"),
)

SLACK = structure(
    "CableSlack",
    "When the cable goes slack: it cannot push down, so the unit only sinks by its weight.",
    Row("pull", "", "of the cable on the unit about that at rest, as a row on the state [m]", shape=(STATES,)),
    Row("reads", "", "sensitivity of each measurement to that pull, in its unit over metres", shape=(MEASUREMENTS,)),
    Row("rate", "", "index of the unit's heave rate in the state"),
    Row("inertia", "s^2", "a of the cable model"),
    Row("largest", "m", "pull downwards at which the cable is slack: the unit's weight in water over the stiffness"),
    Row("tick_period", "s", "time of a step"),
)

FILTER = structure(
    "Filter",
    "Model, measurements and gates of the filter: n states, m measurements.",
    Row("states", "", "n", COUNTER),
    Row("measurements", "", "m", COUNTER),
    Row("kept", "", "ticks that are kept, the present one among them", COUNTER),
    Row("gate_limit", "", "refusals in a row after which the next reading is taken", COUNTER),
    Row("gate", "", "normalised innovation squared above which a gated reading is refused"),
    Row("stream_factor", "", "of the gate, for the step between two innovations of one stream"),
    Row("drag_error", "", "standard deviation of excess drag and of missing push, as a share of them"),
    Row("drag_error_time", "s", "time over which they err in one direction"),
    Row("F", "", "transition of a tick, (n, n)", shape=(STATES * STATES,)),
    Row("B", "", "input of a tick, (n,)", shape=(STATES,)),
    Row("Q", "", "covariance of the process noise of a tick, (n, n)", shape=(STATES * STATES,)),
    Row("added", "", "covariance that is added where the filter is lost, (n, n)", shape=(STATES * STATES,)),
    Row("rows", "", "of the measurements on the state of their tick, (m, n)", shape=(MEASUREMENTS * STATES,)),
    Row("changes", "", "their first differences over ticks, (m, n)", shape=(MEASUREMENTS * STATES,)),
    Row("bends", "", "their second differences over ticks, (m, n)", shape=(MEASUREMENTS * STATES,)),
    Row("scale_states", "", "index of the state that is the relative scale error; -1: none", COUNTER, (MEASUREMENTS,)),
    Row("is_gated", "", "1: refused where it is far off its prediction", COUNTER, (MEASUREMENTS,)),
    Row("drag", "", "of the unit", DRAG),
    Row("slack", "", "of the cable", SLACK),
)

READING = structure(
    "Reading",
    "One reading for the filter.",
    Row("tick", "", "that it belongs to"),
    Row("which", "", "index of the measurement"),
    Row("value", "", "in its unit, about the same mean as the state"),
    Row("offset", "", "how much later than its tick, in ticks"),
    Row("variance", "", "of its noise"),
    Row("first_state", "", "index of a state of which it has a further weight; -1: none"),
    Row("first_weight", "", "that weight"),
    Row("second_state", "", "index of a second such state; -1: none"),
    Row("second_weight", "", "that weight"),
)

FILTER_TICK = structure(
    "FilterTick",
    "Inputs of one filter tick.",
    Row("tick", "", "its number; ticks left out are predicted over"),
    Row("command", "", "of the tick before, held over ticks left out"),
    Row("end", "", "where the readings delivered at it end in the table of the run"),
)

SAID = structure(
    "Said",
    "A reading compared with its prediction; NaN if it came too late.",
    Row("innovation", "", "reading less prediction"),
    Row("sigma", "", "standard deviation of it that was predicted"),
    Row("nis", "", "normalised innovation squared"),
    Row("accepted", "", "1: within its gate"),
)

FILTER_STATE = structure(
    "FilterState",
    "State of the filter. Ring buffers have one entry for each tick.",
    Row("held", "", "ticks that are kept; 0: none was begun", COUNTER),
    Row("newest", "", "newest tick", COUNTER),
    Row("missing_push", "m", "how much further down the model pushes the unit than a slack cable does"),
    Row("x", "", "estimate, (n,)", shape=(STATES,)),
    Row("P", "", "covariance of the estimate, (n, n)", shape=(STATES * STATES,)),
    Row("streams", "", "innovation of the last accepted reading; NaN: none", shape=(MEASUREMENTS,)),
    Row("refusals", "", "in a row", COUNTER, (MEASUREMENTS,)),
    Row("commands", "", "ring of what followed a tick", shape=(PAST_TICKS,)),
    Row("counts", "", "ring of the number of readings used of a tick", COUNTER, (PAST_TICKS,)),
    Row("past", "", "ring of the predictions for a tick: x, then the lower triangle of P", shape=(PAST,)),
    Row("used", "", "ring of the readings used of a tick", READING, (USED,)),
)

PASS = structure(
    "Pass",
    "Model of a pass: n states, k measurements, c columns.",
    Row("states", "", "n", COUNTER),
    Row("measurements", "", "k", COUNTER),
    Row("columns", "", "c, versions of the record", COUNTER),
    Row("ticks", "", "of the record", COUNTER),
    Row("rate", "", "index of the unit's heave rate", COUNTER),
    Row("pad", "", "keeps the numbers aligned", COUNTER),
    Row("F", "", "transition of a tick, (n, n)", shape=(STATES * STATES,)),
    Row("B", "", "input of a tick, (n,)", shape=(STATES,)),
    Row("Q", "", "covariance of the process noise of a tick, (n, n)", shape=(STATES * STATES,)),
    Row("pull", "", "of the cable on the unit, as a row on the state (n,)", shape=(STATES,)),
)

PASS_TICK = structure(
    "PassTick",
    "Drag and slack at one tick of the record, which determine the step of the pass.",
    Row("kept", "", "share that drag leaves of the unit's speed in each half of the tick"),
    Row("gives", "", "share by which a slack cable does not push it"),
    Row("unknown", "m^2/s^2", "variance of its rate that both add"),
    Row("end", "", "where the readings of the tick end in the table"),
)

PASS_READING = structure(
    "PassReading",
    "A reading of the record; its values are stored separately.",
    Row("which", "", "index of the measurement"),
    Row("offset", "", "how much later than its tick it was measured, in ticks"),
    Row("noise", "", "variance"),
    Row("used", "", "1: it is taken in; 0: judged alone"),
)
