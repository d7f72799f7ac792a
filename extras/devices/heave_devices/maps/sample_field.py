"""Where a quantity of a map is in the samples of its device; of live ones and of a log."""

from __future__ import annotations

import math

from heave_devices.formats.sample import Sample
from heave_devices.maps.channel import Channel
from heave_devices.maps.device_map import DeviceMap


class SampleField:
    """Where one quantity is found.

    Parameters
    ----------
    device : the map
    channel : of the quantity
    """

    def __init__(self, device: DeviceMap, channel: Channel) -> None:
        self._channel = channel
        self._device = device
        sentence, _, name = channel.field.partition(".")
        self._sentence, self._name = ("", channel.field) if device.has_names else (sentence, name)
        self._valid = channel.valid if device.has_names else channel.valid.removeprefix(f"{sentence}.")

    def is_in(self, sample: Sample) -> bool:
        """Return whether a `sample` is of the sentence that it is in."""
        return self._sentence in ("", sample.kind)

    def is_invalid(self, sample: Sample) -> bool:
        """Return whether a `sample` calls it invalid, or does not say so."""
        place, _ = self._device.bit_of(self._name)
        if place in sample.invalid:
            return True
        if not self._valid:
            return False
        status = self._number(sample, self._valid)
        word = sample.words.get(self._valid)
        return not self._channel.is_valid(status if word is None else word)

    def number(self, sample: Sample) -> float | None:
        """Return what a `sample` holds of it, as sent, with the sign of its letter; None: nothing."""
        is_there = self._device.bit_of(self._name)[0] in sample.values
        return self._channel.signed(self._number(sample, self._name), sample.words) if is_there else None

    def _number(self, sample: Sample, name: str) -> float:
        place, bit = self._device.bit_of(name)
        value = sample.values.get(place, math.nan)
        return float(int(value) >> bit & 1) if bit is not None and math.isfinite(value) else value
