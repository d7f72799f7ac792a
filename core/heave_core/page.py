"""The page of the core's layout: `python -m heave_core.page > docs/core.md`; a test keeps the two in step."""

from __future__ import annotations

import sys

from heave_core.layout import ENUMERATIONS

HEAD = """# The core's layout

`heave_core` is the compiled part of the controller's tick: C++17 without libraries, allocation, exceptions, clocks or
text. One table, `heave_core.layout`, generates the C++ structures, numpy types on the same memory, and this page.
`python -m heave_core.layout` prints the C++ header: unit and meaning of every field. `winch_controller_node` fills each
`...Design` from its parameters and makes alarms of `News`, `Happened`, `LoadNews`.

| file in `core/heave_core/src/` | what it does |
|---|---|
| `tick.cpp` | a whole tick: read it first |
| `envelope.cpp` | limits commands, takes over, brakes: [the envelope](guide/controller/envelope.md) |
| `ship.cpp`, `drum.cpp`, `move.cpp` | raw readings; nominal drum, driven by the commands sent; requested move |
| `filter.cpp`, `filter_model.cpp`, `filter_steps.cpp` | Kalman filter: gates, late readings, drag, slack cable |
| `pass.cpp` | runs many variants of a linear filter over a record at once, for the adviser |
| `servo.cpp` | simulates a drum driven by the set-points sent, to predict its encoder |
| `drum_watch.cpp`, `encoder_reflex.cpp` | compare commands and encoder of late; set a faulty encoder aside |
| `winch_watch.cpp` | late commands, silent winch, reduced gain while the drum is off its prediction |
| `look.cpp` | motions of boom tip and drum, and of loads simulated with the winch locked and turning |
| `sense.cpp` | first half of a tick: readings, gates, filter, motions |
| `sensor_gate.cpp` | checks each sensor: not a number, bad time stamp, frozen value |
| `noise.cpp` | estimates noise and rate of a sensor from its readings |
| `steps.cpp`, `encoder.cpp` | detect jumps of MRU and depth sensor; compare drum count and commanded travel |
| `terms.cpp` | prepares a gated reading for the filter: subtracts the effect of the mean payout |
| `watches.cpp` | checks filter consistency, mean tension over the waves, and whether the boom tip is known |
| `sea.cpp` | compares the observed sea with the design sea |
| `second.cpp` | runs a second filter in parallel, with another model |
| `unit.cpp`, `nominal_load.cpp` | simulate a load below a known top motion, also with the winch locked |
| `guard.cpp` | detects compensation that makes the motion worse: drum, swing, depth sensor, waves |
| `authority.cpp`, `demand.cpp` | gain predicted to leave the least motion; gain that the winch allows in this sea |
| `supervise.cpp` | decisions of a tick: landing, guard, link, damping, modes; sets a bit per event |
| `start_gates.cpp` | start conditions of compensation and CT mode; tension limit |
| `standing_load.cpp` | checks with the brake on that the cable carries the load; compares payout and depth |
| `modes.cpp`, `attempts.cpp` | run the table of modes, ramp the gain, decide on a further attempt |
| `proofs.cpp`, `fit.cpp` | check the MRU against load cell and depth sensor before the brake opens |
| `brake.cpp` | checks a braked drum by the load cell, and the drum count by the drive's speed |
| `statistics.cpp`, `trend.cpp` | running standard deviations and amplitudes; straight-line fit |
| `landing.cpp` | detects touchdown and lift-off |
| `kpi.cpp` | figures of merit over a rolling window |
| `act.cpp` | second half of a tick: command, mean payout, set-points, envelope, load checks |
| `load_watch.cpp` | detects slack cable, high tension, an overloaded rope, a winch at its limits |
| `laws.cpp` | linear feedback; checks whether a plan keeps the limits without correction |
| `governor.cpp` | limits every command to what the winch can do |
| `command.cpp` | gain, law, effect of the mean payout, limits from the last minute of commands |
| `tension.cpp` | constant tension, also without the MRU |
| `motion.cpp` | mean payout, and the loop's response to it |
| `../plc/controller.cpp` | the whole controller in its own memory, for a [PLC](guide/howto/plc.md) and the FMU |

The C interface is `interface.cpp`. `heave_core_layout` and `heave_core_size` let Python refuse a library with another
layout. A tick is one function, `heave_core_tick`. It returns early where something has happened (`Stage`): a sensor has
failed, the mode has changed, the law needs a plan. Python does its part and calls again. Each sudden change of the
state has a function too (`..._begin`, `..._continue_...`, `..._allow_...`). Python calls them through ctypes and
releases the interpreter lock.
"""


ORDER = ("Gate", "Harm", "Cause", "Happened", "Asks", "LoadNews")
"""Names of numbers in the order of a controller on a PLC (`controller.h`)."""

NUMBERS = """## Numbers

In the order of `controller.h`; all others are in the C++ header.

| what | names |
|---|---|"""


def page() -> str:
    """Return the page as Markdown."""
    kinds = [kind for kind in ENUMERATIONS if kind.__name__ in ORDER]
    names = [NUMBERS, *(f"| `{one.__name__}` | {', '.join(f'{n.name} {int(n)}' for n in one)} |" for one in kinds)]
    return "\n\n".join([HEAD.rstrip(), "\n".join(names)]) + "\n"


if __name__ == "__main__":
    sys.stdout.write(page())
