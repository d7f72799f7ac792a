"""The player: publishes a bag with the recorded types, quality of service and `/clock`."""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from glob import escape
from pathlib import Path
from typing import Any

import rclpy
from builtin_interfaces.msg import Time
from heave_msgs.srv import PlaybackControl
from heave_node.cdr.definitions import is_installed
from heave_node.interface.messages import message_type
from heave_node.ros.node import steady_clock
from heave_node.ros.process import leave_ros
from heave_node.ros.spin import spin
from heave_node.ros.transport.environment import prepare_environment
from heave_node.ros.transport.watchdog import watched_start
from rclpy.exceptions import InvalidNamespaceException, InvalidTopicNameException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.task import Future
from rclpy.utilities import remove_ros_args
from rosgraph_msgs.msg import Clock

from heave_bags.errors import BagError, one_line
from heave_bags.mcap.reader import Bag, BagTopic, RawMessage
from heave_bags.mcap.ros.ros_qos import offer_like
from heave_bags.play.playback import Playback, PlaybackOptions, selected_topics
from heave_bags.play.player_options import DISCOVERY_TIME, add_arguments, options_from

PERIOD = 0.002
"""Wall time between two looks for messages that are due [s]."""
CLOCK_PERIOD = 0.02
"""Wall time between two /clock messages where the bag has none [s]."""
CLOCK = "/clock"


@dataclass(frozen=True)
class Played:
    """What a player has done."""

    messages: int  # number published
    left_out: Mapping[str, str]  # topics that were not, with the reason
    notes: Sequence[str] = ()  # what of the bag could not be read, and what else a reader must know; one line each


class Player(Node):
    """Plays one `bag` as `options` say, after `delay` [s] for discovery. `finished` completes at its end.

    Topics whose type is not installed here are left out, with a warning. Raises BagError if no other is left.

    Services
    --------
    player/control (heave_msgs/srv/PlaybackControl) : pause, rate, step
    """

    def __init__(self, bag: Bag, options: PlaybackOptions, *, delay: float = DISCOVERY_TIME) -> None:
        super().__init__("player")
        self.left_out: dict[str, str] = {}
        self._outlets: dict[str, Publisher[Any]] = {}
        for name in selected_topics(bag, options):
            self._open(bag.topics[name], options)
        if not self._outlets:
            raise BagError(f"{bag.path}: none of its topics can be played: {'; '.join(self.left_out.values())}")
        self.playback = Playback(bag, replace(options, exclude=[*options.exclude, *map(escape, self.left_out)]))
        self.finished: Future[None] = Future()
        self.published = 0
        self._clock_publisher: Publisher[Clock] | None = None
        if CLOCK not in bag.topics:
            self._clock_publisher = self.create_publisher(Clock, CLOCK, 10)
        self._clock_at = 0.0
        self._begin_at = time.monotonic() + delay
        self._has_begun = False
        self.create_service(PlaybackControl, "player/control", self._control)
        self.create_timer(PERIOD, self._play, clock=steady_clock())

    def _open(self, topic: BagTopic, options: PlaybackOptions) -> None:
        """Open the publisher of a topic, or leave it out with a warning."""
        if not is_installed(topic.type):
            self._leave_out(topic.name, f"{topic.type or 'its type'} is not installed here")
            return
        outlet = options.remap.get(topic.name, topic.name)
        try:
            kind = message_type(topic.type)
            self._outlets[topic.name] = self.create_publisher(kind, outlet, offer_like(topic.qos))
        except (ImportError, AttributeError):
            self._leave_out(topic.name, f"{topic.type} cannot be loaded here")
        except (InvalidTopicNameException, InvalidNamespaceException):
            self._leave_out(topic.name, f"{outlet!r} is not a topic name")

    def _leave_out(self, name: str, reason: str) -> None:
        self.left_out[name] = one_line(f"{name} is skipped: {reason}")
        self.get_logger().warning(self.left_out[name])

    def _play(self) -> None:
        now = time.monotonic()
        if now < self._begin_at or self.finished.done():
            return
        if not self._has_begun:
            self._has_begun = True
            self._publish(self.playback.latched())
        self._publish(self.playback.due(now))
        self._report_time(now)
        if self.playback.finished:
            self._end()

    def _publish(self, messages: Sequence[RawMessage]) -> None:
        for message in messages:
            self._outlets[message.topic].publish(message.data)
        self.published += len(messages)

    def _report_time(self, now: float) -> None:
        if self._clock_publisher is None or now - self._clock_at < CLOCK_PERIOD or self.playback.paused:
            return
        self._clock_at = now
        seconds, nanoseconds = divmod(self.playback.time, 1_000_000_000)
        self._clock_publisher.publish(Clock(clock=Time(sec=seconds, nanosec=nanoseconds)))

    def _control(
        self, request: PlaybackControl.Request, response: PlaybackControl.Response
    ) -> PlaybackControl.Response:
        playback = self.playback
        if request.rate < 0.0 or not math.isfinite(request.rate):
            response.success, response.message = False, f"rate {request.rate:g} is not allowed: it must be above 0"
            return response
        if request.step and not request.paused:
            response.success, response.message = False, "stepping requires paused: true"
            return response
        playback.paused = request.paused
        if request.rate > 0.0:
            playback.rate = request.rate
        self._publish(playback.step(request.step) if request.step else [])
        response.success = True
        response.message = f"t = {playback.time * 1e-9:.3f} s, rate {playback.rate:g}" + (
            ", paused" if playback.paused else ""
        )
        return response

    def _end(self) -> None:
        for publisher in self._outlets.values():
            publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=1))
        self.finished.set_result(None)


def play(
    path: str | Path,
    options: PlaybackOptions,
    *,
    delay: float = DISCOVERY_TIME,
    progress: Callable[[float], None] | None = None,
    args: list[str] | None = None,
) -> Played:
    """Play the bag `path` by its `options` to its end, or until the context is shut down; return what was played.

    The first message comes after a `delay` for discovery [s]. `progress` is called a few times a second with the bag
    time reached [s]; `args` are those of ROS, None: of this process. Raises BagError for what cannot be played.
    """
    bag = Bag(path)
    prepare_environment()
    try:
        with watched_start():
            rclpy.init(args=args)
            player = Player(bag, options, delay=delay)
        spin(player, player.finished, lambda: progress(player.playback.time * 1e-9) if progress else None)
        played = Played(player.published, player.left_out, player.playback.remarks)
        leave_ros(player)
    finally:
        rclpy.try_shutdown()
    return played


def main() -> None:
    """Play a bag from the command line."""
    parser = argparse.ArgumentParser(prog="player", description=__doc__)
    add_arguments(parser)
    arguments = parser.parse_args(remove_ros_args(sys.argv)[1:])
    try:
        play(arguments.bag, options_from(arguments), delay=arguments.delay, args=sys.argv)
    except (BagError, MemoryError) as error:
        sys.exit(f"player: {error}")


if __name__ == "__main__":
    main()
