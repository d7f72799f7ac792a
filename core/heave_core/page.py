"""The page of the core's layout: `python -m heave_core.page > docs/core.md`; a test keeps the two in step."""

from __future__ import annotations

import sys

from heave_core.layout import ENUMERATIONS, STRUCTURES
from heave_core.rows import Structure

HEAD = """# The core's layout

`heave_core` is the compiled part of the controller's tick: C++17 without libraries, allocation, exceptions, clocks or
text. One table, `heave_core.layout`, generates the C++ structures, the numpy types through which Python reads and
writes the same memory, and this page. `python -m heave_core.layout` prints the C++ header, with the unit and meaning of
every field.

| part | file in `core/heave_core/src/` | what it does |
|---|---|---|
| envelope | `envelope.cpp` | bounds commands, takes over, brakes: see [the envelope](guide/controller/envelope.md) |
| ship | `ship.cpp` | MRU, drum count and load cell, from raw readings |
| drum | `drum.cpp` | the nominal drum, driven by the commands sent |
| move | `move.cpp` | the move requested by the operator |
| filter | `filter.cpp` | the Kalman filter: gates, sensor streams, late readings |
| filter's model | `filter_model.cpp` | drag, slack cable, measurement row of a reading |
| filter's steps | `filter_steps.cpp` | prediction, correction |
| pass | `pass.cpp` | a linear filter run over a record in many variants at once, for the adviser's searches |
| servo | `servo.cpp` | a simulated drum driven by the set-points sent: what its encoder should have read |
| drum watch | `drum_watch.cpp` | commands and encoder of the last seconds: whether the drum or its encoder is off |
| winch watch | `winch_watch.cpp` | late commands, silent winch, gain reduced while the drum is off |
| look | `look.cpp` | all motions at a tick: boom tip, drum, units simulated with the winch locked and turning |
| sense | `sense.cpp` | the sensing half of a tick: readings, gates, filter, motions, in one call |
| sensor gate | `sensor_gate.cpp` | checks of one sensor alone: not a number, bad stamp, frozen value |
| noise | `noise.cpp` | noise and rate of a sensor, from its own readings |
| steps | `steps.cpp` | jumps of MRU and depth sensor |
| encoder | `encoder.cpp` | drum count compared with the commanded travel |
| terms | `terms.cpp` | a gated reading as the filter needs it, without the mean payout's share |
| watches | `watches.cpp` | consistency, mean tension over the waves, whether the boom tip is known |
| sea | `sea.cpp` | the observed sea compared with the design sea |
| second filter | `second.cpp` | a filter in parallel with the active one, with another model |
| unit | `unit.cpp` | a unit below a top end whose motion is known: quadratic drag, slack cable |
| guard | `guard.cpp` | whether compensation does harm: drum, swing, depth sensor, waves |
| authority | `authority.cpp` | the authority that is predicted to leave the least motion |
| supervision | `supervise.cpp` | what is decided in a tick: landing, guard, link, damping, modes; a bit per event |
| start gates | `start_gates.cpp` | what keeps compensation or constant tension from beginning; a highest tension |
| standing load | `standing_load.cpp` | whether the cable carries the load under a brake; payout against depth |
| modes | `modes.cpp` | the mode machine: runs the table of modes, moves authority |
| attempts | `attempts.cpp` | whether compensation that did harm is tried again, and with what doubt |
| proofs | `proofs.cpp` | MRU proved by load cell and depth sensor before the brake opens |
| fit | `fit.cpp` | a sensor's record fitted on what is expected of it |
| brake | `brake.cpp` | braked drum by the load cell; drum count by the speed that the drive states |
| demand | `demand.cpp` | what the sea demands of the winch, and the gain that this allows |
| statistics | `statistics.cpp` | running standard deviations and amplitudes |
| landing | `landing.cpp` | whether a lowered unit has landed, and whether a lifted one hangs again |
| trend | `trend.cpp` | mean and straight line through the newest readings |
| KPI window | `kpi.cpp` | statistics over the rolling window of the figures of merit |
| act | `act.cpp` | the acting half of a tick: command, mean payout, set-points, envelope |
| nominal load | `nominal_load.cpp` | the nominal unit below a locked drum, moved by the raw MRU |
| load watch | `load_watch.cpp` | slack cable, high tension, rope strength, winch at its limits |
| laws | `laws.cpp` | linear feedback, nearness of limits, whether a plan keeps them without correction |
| governor | `governor.cpp` | limits every command to what the winch can do |
| command | `command.cpp` | gain, law, the mean payout's share, what the last minute of commands allows |
| tension | `tension.cpp` | constant tension, also from tension and drum alone |
| motion | `motion.cpp` | the mean payout, and the loop's response to it |
| controller | `../plc/controller.cpp` | all of it on memory of its own, for a [PLC](guide/howto/plc.md) and the FMU |

The C interface is `interface.cpp`. `heave_core_layout` and `heave_core_size` let Python refuse a library with another
layout. Each part of a tick has a function (`heave_core_sense`, `heave_core_supervise`, `heave_core_act_tick`), and so
has each sudden change of its state (`..._begin`, `..._continue_...`, `..._allow_...`). Python calls them through
ctypes, with the interpreter lock released. To save a part at a tick, copy its state.
"""


def _row(structure: Structure) -> str:
    return f"| `{structure.name}` | {len(structure.rows)} | {structure.meaning} |"


def page() -> str:
    """Return the page as Markdown."""
    names = ["## Numbers", "", "| what | names |", "|---|---|"]
    names += [f"| `{kind.__name__}` | {', '.join(f'{one.name} {int(one)}' for one in kind)} |" for kind in ENUMERATIONS]
    structures = ["## Structures", "", "| structure | fields | what it is |", "|---|---|---|", *map(_row, STRUCTURES)]
    return "\n\n".join([HEAD.rstrip(), "\n".join(names), "\n".join(structures)]) + "\n"


if __name__ == "__main__":
    sys.stdout.write(page())
