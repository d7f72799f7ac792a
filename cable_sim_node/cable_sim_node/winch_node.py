"""ROS shell of the virtual winch."""

from __future__ import annotations

from heave_node.interface import topics
from heave_node.interface.codes import WinchFault
from heave_node.ros.diagnostics import Health, Level, alarm_health
from heave_node.ros.fault_service import FaultService
from heave_node.ros.participant import ParticipantNode
from heave_node.ros.process import run_process
from heave_node.tick.tick import Tick

from cable_sim_node.alarms import fault_alarm
from cable_sim_node.conversions import WINCH_COMMAND, winch_command_of, winch_state_message
from cable_sim_node.winch.component import VirtualWinch
from cable_sim_node.winch.parameters import WinchParameters

CONTROLLER, ENVELOPE = "winch_controller", "winch_envelope"
NOTABLE_DELAY = 0.2
"""Delay that may be the cause of a command timeout [s]."""


class VirtualWinchNode(ParticipantNode):
    """Takes the command of tick k and publishes the state of the winch at t_{k+1}.

    Where a `winch_envelope` takes part in the run, its command counts.
    """

    name = "virtual_winch"
    parameters_type = WinchParameters
    after = (CONTROLLER, ENVELOPE)

    def on_build(self) -> None:
        """Make the winch; one step of a throw-away winch compiles the drive."""
        self._make_winch().step(0, None, 0.0)
        self.winch = self._make_winch()
        self._cause = ""
        self.state = self.add_output(topics.WINCH_STATE)
        is_bounded = ENVELOPE in self.run.participants
        self.command = self.add_input(
            topics.WINCH_COMMAND_WITHIN if is_bounded else topics.WINCH_COMMAND,
            WINCH_COMMAND,
            # what is older than the watchdog's time must not feed it: a controller that was stalled answers for old
            # ticks
            lifespan=self.parameters.command_timeout,
            # a winch that was stalled makes up for each tick with its own command; those of hardware hold from now on
            holds_ahead=is_bounded or CONTROLLER not in self.run.external,
        )
        self.top_tension = self.add_input(topics.CABLE_STATE, ("top_tension",), holds_ahead=True)
        FaultService(self, lambda: {"winch": self.winch.faults, "encoder": self.winch.encoder.faults})

    def on_reset(self) -> None:
        """Start from rest with the brake engaged, without the faults that were injected."""
        self.winch = self._make_winch()

    def on_tick(self, tick: Tick) -> None:
        """Step the winch with the newest command of this tick."""
        commands = self.take(self.command)
        self.take(self.top_tension)
        newest = self.top_tension.latest
        state = self.winch.step(
            tick.number,
            winch_command_of(commands[-1]) if commands else None,
            newest.numbers[0] if newest is not None else float("nan"),
        )
        self.state.publish(winch_state_message(state, tick.end_nanoseconds))
        self._note_cause(tick)

    def on_inactive_tick(self, tick: Tick) -> None:
        """See ParticipantNode. Commands are not taken: the watchdog stops the drum."""
        self.winch.step(tick.number, None)

    def _note_cause(self, tick: Tick) -> None:
        """Note who was silent when the drum has just been stopped by its watchdog: the cause, not what follows."""
        if self.winch.state.fault is WinchFault.DRIVE and self.winch.supervised:
            self._cause = self.winch.supervised
        elif self.winch.state.fault is not WinchFault.COMMAND_TIMEOUT:
            self._cause = ""
        elif not self._cause:
            self._cause = self._who_was_silent(tick)

    def _who_was_silent(self, tick: Tick) -> str:
        """Return in words why no command came in time."""
        late = {
            "ticks began {:.2f} s late, the machine or the clock master stalled": self.punctuality.of_clock,
            "this winch was held up for {:.2f} s": self.punctuality.of_node,
            f"{CONTROLLER} was silent for {{:.2f}} s": self.gate.ticks_behind(CONTROLLER) * self.run.tick_period,
        }
        text, delay = max(late.items(), key=lambda cause: cause[1])
        if delay > NOTABLE_DELAY:
            return text.format(delay)
        command = self.command.latest
        if command is None:
            return "no command has come"
        age = tick.time - 1e-9 * command.stamp
        if age > NOTABLE_DELAY:
            return f"no command has come for {age:.2f} s"
        return "commands came, but did not reach the drive"

    def diagnose(self) -> list[Health]:
        """Say why the winch stopped by itself, and what commands it refused."""
        state = self.winch.state
        values = {"rejected commands": str(self.winch.refused_commands), "brake": str(state.brake)}
        values |= {name: f"{value:.6g}" for name, value in self.winch.instruments().items()}
        if state.fault is WinchFault.NONE:
            return [Health("drive", Level.OK, "ok", values)]
        alarm = fault_alarm(state.fault, state.release, brake=state.brake, cause=self._cause)
        return [alarm_health("drive", alarm, values)]

    def _make_winch(self) -> VirtualWinch:
        return VirtualWinch(self.parameters, tick_period=self.run.tick_period, seed=self.run.seed)


def main() -> None:
    """Run the node."""
    run_process(VirtualWinchNode)


if __name__ == "__main__":
    main()
