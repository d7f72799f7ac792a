"""The seas of an operability study, as a campaign."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from heave_studies.campaign.plan import Campaign, Link

HEIGHT, PERIOD, HEADING = "system.sea.significant_wave_height", "system.sea.peak_period", "system.course.heading"
"""Places of what a sea is given by; the heading is the vessel's [rad]."""

HEIGHTS = (1.5, 3.0, 4.5, 6.0)
"""Significant wave heights of a study where none are given [m]."""
PERIODS = (6.0, 8.0, 10.0, 13.0, 17.0)
"""Peak periods of a study where none are given [s]."""


@dataclass(frozen=True)
class SeaGrid:
    """The seas of a study: every combination, with each seed."""

    heights: tuple[float, ...] = HEIGHTS  # significant wave heights [m]
    periods: tuple[float, ...] = PERIODS  # peak periods [s]
    headings: tuple[float, ...] = ()  # of the vessel, anticlockwise from world x [deg]; empty: the scenario's own
    seeds: tuple[int, ...] = (1, 2)  # of every sea
    # values of other parameters by place, for example of depth or current
    vary: Mapping[str, Sequence[object]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, values in (("heights", self.heights), ("periods", self.periods)):
            if len(values) < 2 or list(values) != sorted(set(values)) or values[0] <= 0.0:
                raise ValueError(f"--{name}: needs at least two values above 0 that rise, not {list(values)}")

    def campaign(
        self, scenario: str, *, settings: Mapping[str, object], wanted: Mapping[str, str], duration: float | None
    ) -> Campaign:
        """Return the campaign that runs these seas.

        Parameters
        ----------
        scenario : shipped name or file
        settings : changes of it in every case, by place
        wanted : criteria beside the scenario's own, by figure of merit
        duration : of a case [s]; None takes the scenario's
        """
        links: list[Link] = [{place: tuple(values)} for place, values in self.vary.items()]
        if self.headings:
            links.append({HEADING: tuple(math.radians(heading) for heading in self.headings)})
        links += [{PERIOD: self.periods}, {HEIGHT: self.heights}]
        return Campaign(
            path=Path("heave operability"),
            scenario=scenario,
            duration=duration,
            seeds=self.seeds,
            common=settings,
            wanted=wanted,
            vary=tuple(links),
        )
