"""A small loop of real processes to test the tick protocol with: sea -> controller -> winch -> plant, with numbers in
place of physics.

Run as `python loop_program.py NODE --ros-args ...`. The parameter `fault` makes the node misbehave at tick
`fault_tick`. Every node checks that it has exactly the messages of its tick, and the plant prints what it saw at the
end.
"""

import gc
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass

from heave_msgs.msg import LoadCell, MruSample, PointMotion, TickStatus, WinchCommand, WinchState
from heave_node.errors import NodeError
from heave_node.interface import topics
from heave_node.parameters import parameter
from heave_node.ros.master import ClockMasterNode
from heave_node.ros.participant import ParticipantNode
from heave_node.ros.process import run_composed, run_process
from heave_node.ros.transport.parents_death import exit_at_once
from heave_node.tick.tick import seconds_of, stamp_of

FAULTS = (
    "",
    "die",
    "hang",
    "late",
    "stop",
    "duplicate",
    "lose",
    "lose_for_ever",
    "future_stamp",
    "old_stamp",
    "raise",
    "bug",
)
MORE_FAULTS = ("slow", "doze", "bug_at_start", "hang_at_exit")


@dataclass(frozen=True)
class LoopParameters:
    fault: str = parameter("", description="How the node misbehaves.", choices=(*FAULTS, *MORE_FAULTS))
    fault_tick: int = parameter(20, "", 1, None, "When.")
    strict: bool = parameter(True, description="Check that each tick has exactly its messages.")


def expect(condition: bool, what: str) -> None:
    if not condition:
        raise NodeError(f"protocol broken: {what}")


class LoopNode(ParticipantNode):
    parameters_type = LoopParameters
    memory = 0

    def on_reset(self) -> None:
        self.memory = 0

    def check(self, tick, got: int, wanted: int, what: str) -> None:
        expect(not self.parameters.strict or got == wanted, f"tick {tick.number}: {got} of {wanted} {what}")

    def send(self, output, message, tick) -> None:
        """Publish as asked, or as the fault has it."""
        fault = self.parameters.fault if tick.number == self.parameters.fault_tick else ""
        if fault == "die":
            os.kill(os.getpid(), signal.SIGKILL)
        if fault == "bug":
            _ = [][tick.number]  # the line that a user must be shown
        if fault == "doze":
            time.sleep(4.0)
        if self.parameters.fault == "slow" and tick.number >= self.parameters.fault_tick:
            time.sleep(3e-9 * tick.period_nanoseconds)
        if fault == "raise":
            raise NodeError("the solver gave up")
        if fault == "hang":
            time.sleep(60.0)
        if fault == "late":
            time.sleep(1.6)
        if fault == "stop":
            subprocess.Popen(["sh", "-c", f"sleep 0.8; kill -CONT {os.getpid()}"])
            os.kill(os.getpid(), signal.SIGSTOP)
        if fault in ("future_stamp", "old_stamp"):
            shift = 10_000_000_000 if fault == "future_stamp" else -tick.period_nanoseconds * 5
            message.header.stamp = stamp_of(tick.start_nanoseconds + shift)
        if fault == "lose_for_ever":
            output.published += 1
            return
        output.publish(message)
        if fault in ("lose", "duplicate"):
            self.send_next_part(0 if fault == "lose" else 2)

    def send_next_part(self, times: int) -> None:
        """Send the next part so many times, and those after it once."""
        send = self.send_part

        def send_once(part) -> None:
            self.send_part = send
            for _ in range(times):
                send(part)

        self.send_part = send_once


class Sea(LoopNode):
    name = "wave_vessel"
    starts_ahead = True

    def on_build(self) -> None:
        self.mru = self.add_output(topics.MRU)
        self.tip = self.add_output(topics.BOOM_TIP)
        self.prepared = 0

    def prepare(self, number: int) -> None:
        self.prepared = number

    def on_tick(self, tick) -> None:
        self.check(tick, self.prepared, tick.number if tick.number > 1 else self.prepared, "is the tick prepared")
        self.memory += 1
        message = MruSample(sequence=self.memory)
        message.header.stamp = tick.stamp
        self.send(self.mru, message, tick)
        tip = PointMotion()
        tip.header.stamp = tick.end_stamp
        self.tip.publish(tip)


class Controller(LoopNode):
    name = "winch_controller"
    after = ("wave_vessel",)

    def on_build(self) -> None:
        if self.parameters.fault == "bug_at_start":
            _ = {}["gain"]  # raised before the run
        wanted = (topics.MRU, topics.LOAD_CELL, topics.WINCH_STATE)
        self.inputs = [self.add_input(topic, holds_ahead=not self.parameters.strict) for topic in wanted]
        self.without_load = 0
        self.command = self.add_output(topics.WINCH_COMMAND)

    def on_tick(self, tick) -> None:
        mru, load, winch = (self.take(port) for port in self.inputs)
        self.without_load += not load
        self.check(tick, len(mru), 1, "mru samples")
        self.check(tick, len(load), 1, "load cell readings")
        self.check(tick, len(winch), int(tick.number > 1), "winch states")
        message = WinchCommand(sequence=tick.number, payout=float(mru[-1].sequence if mru else -1))
        message.header.stamp = tick.stamp
        self.send(self.command, message, tick)

    def on_exit(self) -> None:
        sys.stdout.write(f"without_load={self.without_load}\n")


class Winch(LoopNode):
    name = "virtual_winch"
    after = ("winch_controller",)

    def on_build(self) -> None:
        self.command = self.add_input(topics.WINCH_COMMAND)
        self.state = self.add_output(topics.WINCH_STATE)
        self.oldest = 0.0

    def on_tick(self, tick) -> None:
        commands = self.take(self.command)
        if commands:
            self.oldest = max(self.oldest, tick.time - seconds_of(commands[-1].header.stamp))
        self.check(tick, len(commands), 1, "commands")
        message = WinchState(payout=commands[-1].payout if commands else -1.0)
        message.header.stamp = tick.end_stamp
        self.send(self.state, message, tick)

    def on_exit(self) -> None:
        sys.stdout.write(f"oldest={self.oldest:.3f}\n")
        if self.parameters.fault == "hang_at_exit":  # Python waits for it before it ends
            threading.Thread(target=time.sleep, args=(60.0,)).start()


class Scribe(LoopNode):
    name = "recorder"
    lag = 20

    def on_build(self) -> None:
        self.mru = self.add_input(topics.MRU)

    def on_tick(self, tick) -> None:
        self.take(self.mru)
        if self.parameters.fault == "doze" and tick.number == self.parameters.fault_tick:
            time.sleep(2.0)


class Plant(ClockMasterNode):
    name = "cable_sim"
    parameters_type = LoopParameters
    after = ("wave_vessel", "virtual_winch")

    def on_build(self) -> None:
        self.tip = self.add_input(topics.BOOM_TIP)
        self.winch = self.add_input(topics.WINCH_STATE)
        self.load = self.add_output(topics.LOAD_CELL)
        self.on_reset()

    def on_reset(self) -> None:
        self.sum = 0.0
        self.advanced = 0

    def on_readings(self, tick) -> None:
        if self.parameters.fault == "die" and tick.number == self.parameters.fault_tick:
            os.kill(os.getpid(), signal.SIGKILL)
        message = LoadCell(tension=self.sum)
        message.header.stamp = tick.stamp
        self.load.publish(message)

    def on_advance(self, tick) -> None:
        expect(tick.number == self.advanced + 1, f"tick {tick.number} after {self.advanced}")
        self.advanced = tick.number
        tips, winches = self.take(self.tip), self.take(self.winch)
        if self.parameters.strict:
            counts = (len(tips), len(winches))
            expect(counts == (1, 1), f"tick {tick.number}: {counts} boom tips and winch states")
        self.sum += sum(message.payout for message in winches)

    def on_exit(self) -> None:
        super().on_exit()
        ended = self.run_state == TickStatus.ENDED
        timing = self.timing
        sys.stdout.write(f"ended={ended} ticks={self.tick_number} epoch={self.epoch} sum={self.sum:g}\n")
        sys.stdout.write(f"lost={self.roster.lost_words(self.gate.lost())}\n")
        sys.stdout.write(f"collector={gc.isenabled()} missed={timing.missed_deadlines} resends={timing.resends}\n")


if __name__ == "__main__":
    programs = {program.name: program for program in (Sea, Controller, Winch, Scribe, Plant)}
    if sys.argv[1] == "composed":
        exit_at_once(run_composed([Plant, Sea, Controller, Winch], sys.argv, is_public=False))
    run_process(programs[sys.argv[1]])
