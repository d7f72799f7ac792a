"""The modules that safety rests on, and the tests that have to notice a change of them."""

from __future__ import annotations

from typing import NamedTuple

CONTROLLER = "winch_controller_node/test"
CORE, CORE_TESTS = "core/test", ("test_envelope", "test_look")


class Subject(NamedTuple):
    """A module by name, or a file of the core, and the files of tests that have to notice a change of it."""

    module: str
    tests: tuple[str, ...]


def _controller(module: str, *tests: str) -> Subject:
    return Subject(f"winch_controller_node.{module}", tuple(f"{CONTROLLER}/{test}.py" for test in tests))


def _compiled(file: str, *tests: str) -> Subject:
    return Subject(file, tuple(f"{CORE if test in CORE_TESTS else CONTROLLER}/{test}.py" for test in tests))


SUBJECTS: dict[str, Subject] = {
    "winch": Subject(
        "cable_sim_node.winch.component",
        ("cable_sim_node/test/test_virtual_winch.py", "cable_sim_node/test/test_faulty_drum.py"),
    ),
    "command line": Subject(
        "cable_sim_node.winch.command_line",
        ("cable_sim_node/test/test_command_line.py", "cable_sim_node/test/test_virtual_winch.py"),
    ),
    "faulty drum": Subject("cable_sim_node.winch.faulty_drum", ("cable_sim_node/test/test_faulty_drum.py",)),
    "travel": Subject("heave_node.winch.travel", ("node_base/test/test_travel.py",)),
    "motion supervision": Subject(
        "heave_node.winch.motion_supervision", ("node_base/test/test_motion_supervision.py",)
    ),
    "fault latch": Subject("heave_node.winch.fault_latch", ("node_base/test/test_fault_latch.py",)),
    "taker": Subject("heave_devices.live.taker", ("extras/devices/test/test_taker.py",)),
    "orders": Subject("heave_devices.adapt.orders", ("extras/devices/test/test_adapt_device.py",)),
    "handshake": Subject("heave_devices.live.winch_handshake", ("extras/devices/test/test_winch_handshake.py",)),
    "link watch": Subject("heave_devices.live.link_watch", ("extras/devices/test/test_link_watch.py",)),
    "guard": _controller("core.supervision.guard", "test_guard", "test_guard_checks"),
    "mode machine": _controller("core.supervision.mode_machine", "test_mode_machine", "test_modes"),
    "table of modes": _controller("core.supervision.modes", "test_mode_guards", "test_mode_machine", "test_modes"),
    "timeout cause": _controller("core.supervision.late_commands", "test_timeout_cause"),
    "drum watch": _controller("core.supervision.watch.drum_watch", "test_drum_watch"),
    "encoder reflex": _compiled("encoder_reflex.cpp", "test_drum_watch", "test_encoder_reflex"),
    "load watch": _controller("core.supervision.watch.load_watch", "test_load_watch"),
    "winch watch": _controller("core.supervision.watch.winch_watch", "test_winch_watch"),
    "landing": _controller("core.supervision.landing", "test_landing"),
    "governor": _controller("laws.parts.governor", "test_governor"),
    "compiled envelope": _compiled("envelope.cpp", "test_envelope"),
    "compiled guard": _compiled("guard.cpp", "test_look", "test_checks", "test_guard_checks", "test_guard"),
    "authority": _compiled("authority.cpp", "test_guard", "test_guard_checks"),
    "attempts": _compiled("attempts.cpp", "test_attempts", "test_guard"),
    "modes": _compiled("modes.cpp", "test_mode_guards", "test_mode_machine", "test_modes"),
    "supervision": _compiled("supervise.cpp", "test_supervise", "test_command_timeouts", "test_share_news"),
    "standing load": _compiled("standing_load.cpp", "test_standing_load"),
    "start gates": _compiled("start_gates.cpp", "test_entry_gates", "test_highest_tension"),
    "who may speak": Subject("heave_node.tick.speakers", ("node_base/test/test_speakers.py",)),
    "malformed": Subject("heave_node.tick.malformed", ("node_base/test/test_malformed.py",)),
    "gate": Subject("heave_node.tick.gate", ("node_base/test/test_gate.py", "node_base/test/test_speakers.py")),
    "losses": Subject("heave_bags.mcap.loss", ("bags/test/test_loss.py", "bags/test/test_recorded_losses.py")),
    "sequence gaps": Subject("heave_bags.record.sequence_gaps", ("bags/test/test_recorded_losses.py",)),
}
"""By what each is."""
