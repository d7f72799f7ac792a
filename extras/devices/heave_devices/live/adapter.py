"""A device behind its map: what came in, readings of the suite out. Without ROS and without a clock of its own."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

from heave_node.crane.kinematics import JOINTS
from heave_node.crane.pose import POSE_FIELDS
from heave_node.interface import sensors, topics
from heave_node.interface.codes import MruStatus
from heave_node.interface.sensors import MruReading, WireReading
from heave_node.sensing.recent_motion import RecentMotion
from heave_node.winch.travel import SpeedTravel

from heave_devices.formats.device_time import DeviceTime
from heave_devices.formats.sample import Sample, TimeBase
from heave_devices.live.counted_time import CountedTime, DeviceClock
from heave_devices.live.drum_count import DrumCount
from heave_devices.live.link_watch import LinkWatch
from heave_devices.live.taker import Recent, Taken, Taker
from heave_devices.live.tip_motion import TipMotion, WithoutSteps
from heave_devices.maps.device_map import DeviceMap
from heave_devices.maps.quantities import OUTPUTS

_COUNT_BEGAN = 10**18
"""Stamp of 0 s of a count or counter, and of the first time that no stamp holds [ns]: it is taken for an own one."""
_OWN_FROM, _STAMPS_END = 1e8, 2.0**31
"""A counter that begins between them counts from 1970 or the like, and is a stamp as it is, until 2038 [s]."""
LATE = -1
"""In the place of a time: the sample is older than one before, and is not used."""
NO_STAMP = 0
"""Stamp of a reading whose time of arrival counts."""
WINCH_STATE = "winch/state"
_PLAIN = {sensors.DEPTH.topic.name: "pressure", sensors.LOAD_CELL.topic.name: "tension"}
"""Topics with one number, and the quantity that it is."""


class WinchReading(NamedTuple):
    """What a drive reports of itself; NaN where it does not."""

    stamp: int  # [ns]; 0: the time of arrival counts
    payout: float  # [m]
    payout_rate: float  # [m/s]
    tension: float  # [N]
    brake: float  # other than 0 [-]: engaged
    fault: float  # other than 0 [-]: tripped


class Adapter:
    """One device by its map, `device`: samples or messages in, readings out.

    Attributes
    ----------
    taker, watch : what was not used, and the timing of what came
    heave : the boom tip's motion by the time of arrival, for the simulated plant
    newest : quantities as they came last
    published : readings so far, by topic
    drum_count : whether the count of a drum goes on
    speed_travel : whether a drum's position and speed belong together
    is_counting : False while the device's watchdog has stopped: nothing that it says is used then
    clocks : of the device, by the kind of its samples
    """

    def __init__(self, device: DeviceMap) -> None:
        self.device = device
        self.taker = Taker(device)
        self.watch = LinkWatch(device.timeout)
        self.heave = RecentMotion()
        self._ship = WithoutSteps(self.heave)
        self.newest: dict[str, float] = {}
        self.published = dict.fromkeys(device.outputs, 0)
        self._tip = TipMotion(device.lever_arm)
        self._attitude = Recent(OUTPUTS[sensors.MRU.topic.name][1], device.timeout)
        self._sequence = 0
        self._crane = Recent(POSE_FIELDS, device.timeout)
        self._time = DeviceTime(device.counter_wrap)
        self.clocks: dict[str, DeviceClock] = {}
        self._clock = DeviceClock()
        self._polled: tuple[Sample | None, float] = (None, -math.inf)
        self._began: int | None = None
        self.drum_count = DrumCount()
        self.speed_travel = SpeedTravel()
        self._counted: dict[str, CountedTime] = {}
        self._payout = RecentMotion()
        self._beside = Recent(OUTPUTS[WINCH_STATE][1])
        self._count = math.nan
        self.is_counting = True

    def on_samples(self, samples: Iterable[Sample], now: float) -> list[tuple[str, WireReading | WinchReading]]:
        """Return the readings, each with its topic, that `samples` which arrived at `now` [s] make."""
        made = []
        for sample in samples:
            own = self._own_time(sample, now)
            if own == LATE or (self.device.is_polled and self._is_repeated(sample, own, now)):
                continue
            stamp, time = self._stamp(own, now, sample.kind)
            made += self._made(self.taker.of_sample(sample, time), stamp, now)
        return made

    def on_message(
        self, topic: str, message: Any, stamp: int | None, now: float
    ) -> list[tuple[str, WireReading | WinchReading]]:
        """Return the readings, each with its topic, that a `message` makes, an object with the fields of the map.

        It came on a `topic` at the monotonic time `now` [s], with a `stamp` in its header [ns]; None: it has none.
        """
        used, time = self._stamp(stamp, now)
        return self._made(self.taker.of_message(topic, message, time), used, now)

    def _own_time(self, sample: Sample, now: float) -> int | None:
        """Return the time of a sample that arrived at `now` [s] by the device's own clock [ns].

        None: it has none. LATE: it is older than one before.
        """
        sample = self.device.own_time(sample)
        own = self._time.nanoseconds(sample)
        if own is None:
            return None
        self._clock = self.clocks.setdefault(sample.kind, DeviceClock())
        time = self._clock.time(own * 1e-9, now)
        if time is None:
            return LATE
        if self._began is None:
            is_count = sample.time_base is TimeBase.COUNTER and time < _OWN_FROM
            first = round(time * 1e9) if time >= _STAMPS_END else 0
            self._began = _COUNT_BEGAN - first if is_count or first else 0
        return self._began + round(time * 1e9)

    def _is_repeated(self, sample: Sample, own: int | None, now: float) -> bool:
        """Return whether a `sample` with an `own` time that comes `now` [s] is the one before; one that lasts not."""
        before, at = self._polled
        is_repeated = own is not None and sample == before and now - at < self.device.timeout / 3.0
        self._polled = self._polled if is_repeated else (sample, now)
        return is_repeated

    def _stamp(self, own: int | None, now: float, kind: str = "") -> tuple[int, float]:
        """Return the stamp [ns] and the time [s] of what has an `own` time [ns], or none, and arrived at `now` [s].

        Without one, samples of each `kind` are counted where the map states their rate; else the time of arrival
        counts.
        """
        if self.device.clock == "own" and own is not None:
            return own, own * 1e-9
        rate = self.device.sample_rate
        if not (kind and rate):
            return NO_STAMP, now
        time = self._counted.setdefault(kind, CountedTime(rate)).time(now)
        return _COUNT_BEGAN + round(time * 1e9), time

    def _made(self, taken: Taken, stamp: int, now: float) -> list[tuple[str, WireReading | WinchReading]]:
        if not taken.values and not taken.invalid:
            return []
        self.newest.update(taken.values)
        for name in taken.invalid:
            self.newest.pop(name, None)
        has_counted = self._has_counted(taken)
        self.is_counting = has_counted or not self.watch.is_stale(now)
        if not self.is_counting:
            return []
        made: list[tuple[str, WireReading | WinchReading]] = []
        for topic in self.device.outputs:
            reading = self._reading(topic, taken, stamp)
            if topic == sensors.MRU.topic.name and isinstance(reading, WireReading):
                self._note_heave(now, reading.numbers[0])
            if reading is not None:
                made.append((topic, reading))
                self.published[topic] += 1
        if made and has_counted:
            self.watch.arrived(now)
        return made

    def _has_counted(self, taken: Taken) -> bool:
        """Return whether the device's watchdog, if its map has one, has counted since the sample before."""
        if "watchdog" not in self.device.channels:
            return True
        before, self._count = self._count, taken.values.get("watchdog", self._count)
        return self._count != before

    def _note_heave(self, now: float, heave: float) -> None:
        if math.isfinite(heave):
            time = now - self.device.latency
            self.heave.add(time, self._ship.at(time, heave))

    def _reading(self, topic: str, taken: Taken, stamp: int) -> WireReading | WinchReading | None:
        if topic == sensors.MRU.topic.name:
            sample = self._motion(taken)
            return None if sample is None else WireReading(stamp, sensors.MRU.encode(sample, sensors.STANDARD_WATER))
        if topic == WINCH_STATE:
            return self._winch(taken, stamp)
        if topic == topics.CRANE_POSE.name:
            pose = self._crane.take(taken)
            return WireReading(stamp, tuple(pose.values())) if taken.has_any(JOINTS) else None
        name = _PLAIN[topic]
        if name not in taken.values:
            return None
        sigma = self.device.channels[name].sigma
        accuracy = sigma * sigma if topic == sensors.DEPTH.topic.name else sigma
        return WireReading(stamp, (taken.values[name], accuracy if math.isfinite(accuracy) else 0.0))

    def _motion(self, taken: Taken) -> MruReading | None:
        """Return the reading that a sample, `taken`, completes; None where it holds no heave, nor calls it invalid."""
        rate, acceleration, roll, pitch, *turning = self._attitude.take(taken).values()
        if not taken.has_any(["heave"]):
            return None
        self._sequence += 1
        read = taken.values.get("heave", math.nan)
        heave, rate, added = self._tip.carry(taken.time, read, rate, (roll, pitch), (turning[0], turning[1]))
        sigma = {name: channel.sigma for name, channel in self.device.channels.items()}
        if added > 0.0:
            stated = sigma.get("heave_rate", math.nan)
            sigma["heave_rate"] = math.hypot(stated, added) if math.isfinite(stated) else added
        return MruReading(
            taken.time,
            heave,
            rate,
            roll if math.isfinite(roll) else 0.0,
            pitch if math.isfinite(pitch) else 0.0,
            int(taken.status if math.isfinite(heave) else MruStatus.INVALID),
            self._sequence,
            math.nan if any(self.device.lever_arm) else acceleration,
            sigma.get("heave", math.nan),
            sigma.get("heave_rate", math.nan),
        )

    def _winch(self, taken: Taken, stamp: int) -> WinchReading | None:
        measured_rate, *beside = self._beside.take(taken).values()
        if "payout" not in taken.values:
            return None
        is_measured = "payout_rate" in self.device.channels
        rate = measured_rate if is_measured else self._recent_rate(taken.time)
        payout = self._counted_on(taken.values["payout"], rate, taken.time)
        self._payout.add(taken.time, payout)
        if is_measured and math.isfinite(rate):
            self.speed_travel.look(taken.time, payout, rate)
        else:
            self.speed_travel.restart()
        rate = rate if is_measured else self._recent_rate(taken.time)
        return WinchReading(stamp, payout, rate, *beside)

    def _recent_rate(self, time: float) -> float:
        """Return the drum's speed over the last readings at a `time` [s]; NaN: not known."""
        recent = self._payout.at(time)
        return math.nan if recent is None else recent[1]

    def _counted_on(self, payout: float, rate: float, time: float) -> float:
        """Return a `payout` of a `time` [s], counted on where the drum's count was lost; its `rate` as measured."""
        jump = self.drum_count.jump(time, payout, rate, has_restarted=self._clock.has_stepped)
        if jump:
            hint = self.taker.jump_in_other_order("payout", jump)
            self.drum_count.words += f"; {hint}" if hint else ""
            zeros = self.taker.zeros
            zeros["payout"] = zeros.get("payout", 0.0) + jump
            self.newest["payout"] = payout - jump
        return payout - jump
