"""Parts of the core by themselves: any C++ function of its library by name, and the shells that tests need of them.

The C interface has what the controller calls. A test may call whatever is in a header: names, and types of arguments,
are those of the symbols of the library (`nm`, `c++filt`).
"""

from __future__ import annotations

import ctypes
import math
import re
import subprocess
from collections import namedtuple
from functools import lru_cache

import numpy as np
from heave_core import law, law_table, layout
from heave_core.envelope_table import READINGS
from heave_core.law import ACTING, SUPERVISING, Control
from heave_core.law_table import Stage, Stop
from heave_core.library import dtype_of, fill, library, new
from heave_core.look_table import HANGING_CABLE, HANGING_UNIT, SIGMA
from heave_core.sense_table import DELIVERED
from heave_core.watch_table import LANDING_STATE
from heave_node.interface.codes import WinchLimit
from winch_controller_node.core.estimation.core_tick import put_readings
from winch_controller_node.core.estimation.loop_estimation import LoopEstimation
from winch_controller_node.core.supervision import late_commands, proofs
from winch_controller_node.core.supervision.watch import load_watch, winch_watch
from winch_controller_node.laws.parts.governor import GovernedCommand, drum_ahead, shaped_by
from winch_controller_node.model.simulated_unit import hanging_cable

NUMBER, COUNT, FLAG = ctypes.c_double, ctypes.c_int, ctypes.c_bool
"""Types of a result."""

KINDS = {"double": NUMBER, "int": COUNT, "bool": FLAG}


@lru_cache
def numbers(count):
    """Return the type of a structure of so many numbers, as it is handed over by value."""
    return type("Numbers", (ctypes.Structure,), {"_fields_": [("row", NUMBER * count)]})


@lru_cache
def symbols():
    """Return the functions of the library: what C++ calls them, and what the linker does."""
    command = ["nm", "-D", "--defined-only", library()._name]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    mangled = [line.split()[-1] for line in listed.splitlines() if " T _ZN5heave" in line]
    plain = subprocess.run(["c++filt"], input="\n".join(mangled), capture_output=True, text=True, check=True).stdout
    return dict(zip(plain.splitlines(), mangled, strict=True))


@lru_cache
def part(name, first="", result=None):
    """Return a function of the core, which takes arrays for pointers and references, and rows for values.

    Parameters
    ----------
    name : of it; `first` the structure that is its first argument, where others have its name
    result : NUMBER, COUNT, FLAG, a structure, or how many numbers there are in the one that it returns
    """
    pattern = re.compile(rf"heave::{name}\(({f'heave::{first}' if first else ''}\b.*)\)")
    (found,) = [(match[1], one) for one in symbols() if (match := pattern.fullmatch(one))]
    kinds = [_kind(one) for one in found[0].split(", ")]
    function = library()[symbols()[found[1]]]
    function.argtypes = kinds
    function.restype = numbers(result) if isinstance(result, int) else result

    def call(*given):
        # arrays of addresses are held here until the call is over
        tables = {place: np.array([_address(x) for x in one], np.uintp) for place, one in _tables(given, kinds)}
        values = [tables.get(place, one) for place, one in enumerate(given)]
        made = function(*(_given(one, kind) for one, kind in zip(values, kinds, strict=True)))
        return list(made.row) if isinstance(result, int) else made

    return call


def _kind(declared):
    """Return the type of an argument that C++ declares so."""
    if declared.endswith(("&", "*")):
        return ctypes.c_void_p
    structures = {f"heave::{one.name}": one for one in layout.STRUCTURES}
    return KINDS.get(declared) or numbers(dtype_of(structures[declared]).itemsize // 8)


def _tables(given, kinds):
    """Return the arguments that are structures of references, with their places."""
    found = [(place, one) for place, one in enumerate(given) if isinstance(one, tuple)]
    return [(place, one) for place, one in found if kinds[place] is ctypes.c_void_p]


def _address(array):
    return array if isinstance(array, int) else 0 if array is None else array.ctypes.data


def _given(one, kind):
    if isinstance(one, np.ndarray) and kind is ctypes.c_void_p:
        return one.ctypes.data
    return one if kind in (ctypes.c_void_p, *KINDS.values()) else kind((NUMBER * len(one))(*one))


# units


class HangingUnit:
    """A simulated unit below an outlet whose motion is known, on a `cable` by the names of HANGING_CABLE."""

    def __init__(self, cable):
        self.cable, self.unit = new(HANGING_CABLE), new(HANGING_UNIT)
        self.take_cable(cable)

    def take_cable(self, cable):
        """Go on with another `cable`."""
        fill(self.cable[0], cable)

    @property
    def motion(self):
        """Heave [m] and heave rate [m/s], shape (2,)."""
        return np.array(part("motion_of", result=2)(self.cable, self.unit))

    def continue_at(self, heave, rate):
        """Go on from another `heave` [m] and `rate` [m/s]."""
        part("continue_at")(self.cable, self.unit, np.array([heave, rate]))

    def step(self, heave, rate):
        """Advance by a tick below an outlet with this `heave` [m] and `rate` [m/s] at its start; return `motion`."""
        part("advance_unit")(self.cable, self.unit, np.array([heave, rate]))
        return self.motion


class SimulatedUnit(HangingUnit):
    """The same on a CableModel, in ticks of `tick_period` [s]; motions are arrays of heave and rate."""

    def __init__(self, cable, tick_period):
        super().__init__(hanging_cable(cable, tick_period))

    @property
    def state(self):
        """Heave [m] and heave rate [m/s], shape (2,)."""
        return self.motion

    def take_cable(self, cable, tick_period=None):
        """Go on with another `cable`."""
        super().take_cable(cable if tick_period is None else hanging_cable(cable, tick_period))

    def continue_at(self, state):
        """Go on from another `state`, shape (2,)."""
        super().continue_at(*state)

    def step(self, outlet):
        """Advance by a tick below an `outlet`, shape (2,), and return the state."""
        return super().step(*outlet)


class RunningSigma:
    """Exponentially weighted standard deviation about a mean that is followed `slow_mean` times more slowly."""

    def __init__(self, time_constant, tick_period, slow_mean):
        self.memory, self._given = new(SIGMA), (tick_period / time_constant, slow_mean)

    def add(self, value):
        """Take a `value` in."""
        weight, slow_mean = self._given
        part("add", "RunningSigma")(self.memory, value, weight, slow_mean)

    @property
    def sigma(self):
        """Standard deviation, in the unit of the values."""
        return math.sqrt(float(self.memory["variance"][0]))


# command


def governed_by(winch, wanted):
    """Return the numbers of `Governed` for the numbers of `Wanted`, by an array of one ActiveWinch."""
    return part("govern", result=len(law_table.GOVERNED.rows))(winch, np.array(wanted, dtype=float))


class CommandGovernor:
    """Saturates commands against the predicted state of an ActiveWinch in a design's `model`."""

    def __init__(self, model, winch):
        self.limits, self._record, self._ahead = winch.limits, winch.record, drum_ahead(model, winch.winch)

    def predict(self, x):
        """Return payout [m] and rate [m/s] at the moment the next command takes effect, from the model's state `x`."""
        return (self._ahead @ x).tolist()

    def govern(self, wanted, payout, rate, tension, within=(math.nan, math.nan)):
        """Return the nearest command to `wanted` within the limits."""
        row = (wanted, payout, rate, tension, *within, -math.inf, math.inf)
        value, sent, shaped = governed_by(self._record, row)
        is_first_order = bool(self._record["is_first_order"][0])
        return GovernedCommand(value, shaped_by(int(shaped), is_first_order=is_first_order), sent)


USUAL = {"tension": math.nan, "filtered_tension": math.nan, "bounds_tension": 1.0, "follows_tip": 1.0}
USUAL |= {"lowest": -math.inf, "highest": math.inf}
LoopNow = namedtuple(
    "LoopNow",
    [row.name for row in law_table.LOOP.rows if not row.shape],
    defaults=[USUAL.get(row.name, 0.0) for row in law_table.LOOP.rows[1:] if not row.shape],
)
"""What is known of the loop in a tick, and what is to be done: the numbers of `Loop`."""


def pose(core, loop):
    """Pose the problem of a tick of a Commander in a `loop`; return what it stands on."""
    found = core.records
    found["loop"].view("f8")[: len(loop)] = loop
    on = tuple(found[name] for name in ("winch", "design", "loop"))
    part("pose_problem")(on, found["problem"], found["command"])
    return on


def act(core, loop):
    """Make the command of a tick of a Commander in a `loop`; return what is needed for it first, 0 where it is made."""
    found, on = core.records, pose(core, loop)
    asked = [found[name] for name in ("law", "problem", "law_state", "state", "command")]
    asks = part("ask_command", result=COUNT)(on, *asked)
    if asks == 0:
        part("make_command")(on, found["problem"], found["state"], found["command"])
    return asks


def bounds(core_law, state):
    """Return lower and upper bounds of a CoreLaw's plan at a LoopState, the mean payout's share subtracted."""
    core_law._pose(state)
    core = core_law.core
    part("bound_plan")(core.winch, core.law, core.problem, core.state)
    return core_law.planner.bounds()


class Place(law.Place):
    """The place that belongs to a commanded speed."""

    def at_end(self, tick_period, rate, payout, *, is_braked):
        """Return the place [m] at the end of a tick: of a `rate` [m/s] that is sent, the drum being at a `payout`."""
        return part("place_at_end", result=NUMBER)(self.record, tick_period, rate, payout, is_braked)


def change_order(controller, change):
    """Let `change` do what it likes to the order of a controller, by the names of READINGS, before the envelope."""
    begin, ordered = controller._begin, controller.envelope.records["readings"].view(dtype_of(READINGS))

    def changed():
        acting = tuple(controller._control.records(ACTING).values())
        if asks := part("answer", result=COUNT)(acting):
            controller._command.ask(asks)
            part("make")(acting)
        change(ordered)
        return Stage.SEND

    controller._begin = lambda tick, measurements: begin(tick, measurements, stops=Stop.BEFORE_ANSWER)
    controller._goes_on[Stage.ANSWER] = changed


# constant tension


def note_tension(record, tension, payout):
    """Take `tension` [N] and `payout` [m] of a tick into a TensionRecord."""
    part("note_tension")(record.record, tension, payout)


TensionRate = namedtuple("TensionRate", ("tip", "correction"))


def lead_alone(alone, record, set_point, *, unit_stands):
    """Return the two rates [m/s] that a TensionAlone asks for: what follows the boom tip, and the correction."""
    given = record.record, set_point, alone.largest, unit_stands, alone.core
    return TensionRate(*part("lead_alone", result=2)(*given))


# watches


LANDING_SEEN = 11
"""Numbers of `LandingSeen`."""


def add_depth(landing, time, depth):
    """Take a reading of the `depth` [m], positive down, of a `time` [s] into a LandingWatch."""
    part("add", "Trend")(landing.state["depth"], time, depth)


def observe_landing(landing, *seen):
    """Take the first numbers of `LandingSeen` of a tick into a LandingWatch."""
    landing.seen = rows = np.zeros(LANDING_SEEN)
    rows[: len(seen)] = seen
    part("observe_landing")(landing.design, landing.state, rows)


def shows_hanging(landing):
    """Tell whether what rides on the unit of a Landing says something of a hanging one."""
    return part("shows_hanging", result=FLAG)(landing.core.state)


def judge_landing(landing, *seen):
    """Return what has happened in the tick that a LandingWatch has observed, by the last numbers of `LandingSeen`."""
    landing.seen[-len(seen) :] = seen
    part("judge_landing")(landing.design, landing.state, landing.seen)
    return int(landing.state["event"][0])


TrendFound = namedtuple("TrendFound", ("slope", "error", "is_known", "mean"))


def trend_of(landing, name, window):
    """Return slope, its standard error, whether they are known, and the mean of a trend over a `window` [s]."""
    trend, design = landing.state[name], landing.design[0]
    found = part("slope_of", result=Slope)(trend, window, float(design["least_readings"]), float(design["filled"]))
    return TrendFound(found.value, found.error, found.is_known, part("mean_of", result=NUMBER)(trend, window))


class Slope(ctypes.Structure):
    """A slope, its standard error, and whether they are known."""

    _fields_ = (("value", NUMBER), ("error", NUMBER), ("is_known", FLAG))


def watch_load(record, tension, static_tension, *, is_at_limit):
    """Take a tick into a LoadRecord, with tensions [N]; return the bits of LoadNews."""
    given = record.records["load"], record.state, tension, static_tension, is_at_limit
    return part("watch_load", result=COUNT)(*given)


class LoadWatch(load_watch.LoadWatch):
    """The alarms of load and winch, a tick at a time."""

    def update(self, tension, static_tension, *, is_at_limit):
        """Return what has just become wrong, with tensions [N]."""
        found = watch_load(self._core, tension, static_tension, is_at_limit=is_at_limit)
        return self.alarms(found, tension, static_tension)


Driven = namedtuple("Driven", ("waits", "hangs", "taken_over", "latest", "has_mru"), defaults=("", math.inf, True))
"""What the winch is used for in a tick."""

Proven = namedtuple("Proven", ("gate", "alarms"))
"""What follows from the proofs of a tick."""


class Proofs(proofs.Proofs):
    """The proofs, a tick at a time."""

    brake = True

    def note(self, sent):
        """Note the order that was `sent` in this tick."""
        self.brake = sent.brake

    def step(self, raw, driven):
        """Take in the `raw` readings of a tick, in which the winch is `driven` so."""
        winch, rows = raw.winch, np.zeros((64, len(DELIVERED.rows)))
        count = put_readings(rows, raw)
        of_winch = (0.0,) * 4 if winch is None else (1.0, *winch[:3])
        runs, has_swung = driven.taken_over == "DRUM_NOT_HELD: count", driven.taken_over == "LOAD_SWUNG_HIGHER"
        seen = (driven.latest, *of_winch, self.brake, driven.waits, driven.hangs, driven.has_mru, runs, has_swung)
        on = self.design, np.array(seen, float), rows, count, self.state
        news = part("prove", "ProofDesign", COUNT)(*on, self.records["proof_work"])
        found = self.alarms(news, winch) if news else ()
        return Proven(self.gate, found)


Ordered = namedtuple("Ordered", ("share", "left", "payout", "is_limited"), defaults=(False,))
"""What the encoder reads of what a drum was ordered: the numbers of `Ordered`."""


def drum_error(watch):
    """Return how far the drum of a DrumWatch, or of DrumOrders, is off what was predicted a second ago [m]."""
    orders = getattr(watch, "_core", watch)
    return part("drum_error", result=NUMBER)(orders.design, orders.state, tuple(orders.room.values()))


def drum_ordered(watch):
    """Return what the encoder reads of what the assumed drum of a DrumWatch, or of DrumOrders, was ordered, or None."""
    orders = getattr(watch, "_core", watch)
    given = orders.design, orders.state, tuple(orders.room.values()), orders.design["assumed"]
    found = Ordered(*part("drum_ordered", result=len(Ordered._fields))(*given))
    return None if math.isnan(found.share) else found._replace(is_limited=bool(found.is_limited))


def reads(reflex, ordered, what, *was):
    """Tell whether the encoder reads as `what` says, by an EncoderReflex, of what was Ordered."""
    return part(f"reads_{what}", result=FLAG)(reflex.design, np.array(ordered, float), *was)


def look_at_encoder(reflex, tick, ordered, *, is_aside):
    """Return what an EncoderReflex finds in a tick, by what was Ordered; None: unknown."""
    shown = np.array((math.nan, 0.0, 0.0, 0.0) if ordered is None else ordered, float)
    return part("look_at_encoder", result=COUNT)(reflex.design, reflex.state, tick, shown, is_aside)


def watch_winch(record, *seen):
    """Take a tick into a WinchRecord, by the rows of WINCH_SEEN."""
    design, state, rows, work, minute = record.records.values()
    part("watch_winch")(design, state, (rows, work), minute, np.array(seen, float))


class WinchWatch(winch_watch.WinchWatch):
    """The watch of a winch, a tick at a time."""

    given, fault = None, 0

    def give(self, order):
        """Note the order of a tick."""
        self.given, self.kept = order, 0

    def watch(self, winch, payout, tension, parameters):
        """Put the set-points of the last tick and what the encoder made of them on record; return late commands."""
        self.refer_to(parameters)
        self.fault = self.fault if winch is None else winch.fault
        order = (math.nan, 0.0, 0.0, False) if self.given is None else self.given[:4]
        taken, limits = (0, 0) if winch is None else winch[-2:]
        seen = winch is not None, taken, limits & WinchLimit.PAYOUT, limits != 0
        watch_winch(self._core, *seen, *order, math.nan if payout is None else payout, tension)
        return self.transport()


class Sensing(LoopEstimation):
    """The estimation, by sensing halves of ticks."""

    def __init__(self, design):
        self.control, self._landing, self._command = Control(), new(LANDING_STATE), new(law_table.COMMAND)
        super().__init__(design, self.control)
        self.control.take(SUPERVISING, landing_state=self._landing)
        self.control.take(ACTING, command=self._command, motion=self.motion.record)

    def step(self, number, measurements, command, *, unit_stands):
        """Sense a tick under a `command` of its two shares; return it."""
        self._command["compensating"], self._command["mean"] = command
        self._landing["unit_stands"] = unit_stands
        readings = self.deliver(number, measurements, command)
        self.control.begin(Stage.SENSE, measurements.winch, number, readings, Stop.AFTER_SENSE, 0.0)
        self.note(len(self._core.observed), 0)
        return self.tick


def note_command(link, given, taken, modelled):
    """Take in the numbers of the last command `given`, and of the newest `taken`, late beyond `modelled` [s]."""
    part("note_command")(*link.at, given, taken, modelled)


class LateCommands(late_commands.LateCommands):
    """Commands that are late, one by one."""

    def update(self, given, taken, delay):
        """Return what is wrong, once each time, by the numbers of the commands `given` and `taken`; None: nothing."""
        note_command(self._link, given, taken, delay)
        return self.news


def add_to_window(ring, *row):
    """Take one tick into a KpiRing, by the rows of KPI_ROW."""
    part("add", "KpiDesign")(*ring.records.values(), row)
