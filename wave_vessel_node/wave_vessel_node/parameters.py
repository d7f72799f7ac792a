"""The parameter set of the sea and vessel."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.files.plausible import breaking_words
from heave_node.parameters import group, parameter
from heave_node.registry import describe_choices

from wave_vessel_node.crane_parameters import CraneMotionParameters
from wave_vessel_node.mru_parameters import MruParameters, SeaStateEstimateParameters
from wave_vessel_node.sea_registry import AUTO, FILTER_FORMS, NEED_NO_PERIOD, SPECTRA, SPECTRUM_FILE
from wave_vessel_node.source_registry import SOURCES
from wave_vessel_node.vessel_parameters import CourseParameters, DriftParameters, VesselParameters

FILTER_CHOICES = (AUTO, *FILTER_FORMS)


@dataclass(frozen=True)
class SwellParameters:
    """The second (low-frequency) system of an Ochi-Hubble sea."""

    significant_wave_height: float = parameter(1.0, "m", 0.0, 25.0, "Significant wave height of the swell alone.")
    peak_period: float = parameter(16.0, "s", 1.0, 40.0, "Peak period of the swell.")
    shape: float = parameter(3.0, "", 0.5, 20.0, "Ochi-Hubble shape of the swell; 1 is Bretschneider's.")


@dataclass(frozen=True)
class SeaParameters:
    """A sea that a few numbers describe; which spectrum takes which of them: see `sea_registry`."""

    spectrum: str = parameter("bretschneider",
        description=f"Spectrum of the sea: {describe_choices(SPECTRA)}.", choices=tuple(SPECTRA))  # fmt: skip
    significant_wave_height: float = parameter(1.0, "m", 0.0, 25.0,
        "Significant wave height (of the wind sea in ochi_hubble).")  # fmt: skip
    peak_period: float = parameter(8.0, "s", 1.0, 40.0,
        "Peak period (of the wind sea in ochi_hubble); pierson_moskowitz derives it from the height.")  # fmt: skip
    peak_enhancement: float = parameter(3.3, "", 1.0, 10.0, "gamma of the JONSWAP spectrum.")
    shape: float = parameter(1.0, "", 0.5, 20.0, "Ochi-Hubble shape of the wind sea; 1 is Bretschneider's.")
    swell: SwellParameters = group(SwellParameters)


@dataclass(frozen=True)
class LaterSeaParameters:
    """Another sea of the same spectrum and direction, into which the first one goes over."""

    significant_wave_height: float = parameter(1.0, "m", 0.0, 25.0, "Significant wave height of the later sea.")
    peak_period: float = parameter(8.0, "s", 1.0, 40.0, "Peak period of the later sea.")
    start: float = parameter(0.0, "s", 0.0, None, "Time at which the change begins.")
    duration: float = parameter(0.0, "s", 0.0, 1e5, "How long the change takes; 0: there is no later sea.")


@dataclass(frozen=True)
class SpreadingParameters:
    """Directional spreading of the wave energy."""

    exponent: float = parameter(0.0, "", 0.0, 500.0,
        "s of cos^2s(angle/2) spreading about the direction; 0 means long-crested.")  # fmt: skip


@dataclass(frozen=True)
class ShapingFilterParameters:
    """The shaping filter that the source `filter` drives with white noise."""

    form: str = parameter("auto",
        description=f"Shaping filter: {describe_choices(FILTER_FORMS)}; auto selects the best fit.",
        choices=FILTER_CHOICES)  # fmt: skip
    states: int = parameter(6, "", 4, 16, "States of a fitted filter; even.")


@dataclass(frozen=True)
class PreviewParameters:
    """The preview of the boom tip, as of waves that are measured up-sea or by radar."""

    time: float = parameter(0.0, "s", 0.0, 120.0, "How far the preview of the boom tip looks ahead; 0: there is none.")
    noise: float = parameter(0.05, "m", 0.0, 10.0,
        "White error of the preview at each moment, 1 sigma; a moment keeps its error.")  # fmt: skip


@dataclass(frozen=True)
class WaveVesselParameters(SeaParameters):
    """Everything of `wave_vessel`: the sea, the vessel, its course, the motion reference unit and the preview."""

    boom_tip_source: str = parameter("spectrum",
        description=f"What moves the boom tip: {describe_choices(SOURCES)}.", choices=tuple(SOURCES))  # fmt: skip
    boom_tip_height: float = parameter(0.0, "m", -100.0, 200.0, "Mean height of the boom tip above still water.")
    ramp: float = parameter(60.0, "s", 0.0, 3600.0,
        "Time over which all motion ramps up from rest (twice differentiable); 0 starts at full motion.")  # fmt: skip
    amplitude: tuple[float, ...] = parameter((0.0, 0.0, 1.0), "m", -50.0, 50.0,
        "Source regular: boom tip moves as a_i sin(2 pi t / period) along world x, y, z.", length=3)  # fmt: skip
    period: float = parameter(10.0, "s", 0.5, 1000.0, "Period of the source regular.")
    spectrum: str = parameter("bretschneider",
        description=f"Spectrum of the sea: {describe_choices(SPECTRA)}, {SPECTRUM_FILE} (measured).",
        choices=(*SPECTRA, SPECTRUM_FILE))  # fmt: skip
    direction: float = parameter(3.141592653589793, "rad", -6.3, 6.3,
        "Direction the waves travel to, from world x, anticlockwise; pi is a head sea for heading 0.")  # fmt: skip
    later_sea: LaterSeaParameters = group(LaterSeaParameters)
    spreading: SpreadingParameters = group(SpreadingParameters)
    components: int = parameter(800, "", 1, 20000, "Number of components of the source spectrum.")
    spectrum_file: str = parameter("",
        description="Measured spectrum for spectrum = file: NDBC real-time or historical, or what wavespectra reads.",
    )  # fmt: skip
    spectrum_record: int = parameter(0, "", 0, None,
        "Index of the usable spectrum in the file, from 0 in order of time.")  # fmt: skip
    spectrum_time: str = parameter("",
        description="Take the spectrum nearest to this time (UTC, like 1996-06-14T18:00); empty: by record.",
    )  # fmt: skip
    recording_file: str = parameter("",
        description="Recording for boom_tip_source = file: CSV, or a bag (folder or .mcap).")  # fmt: skip
    recording_kind: str = parameter("motion",
        description="Content of the recording: boom-tip motion, or wave elevation, which is passed through the vessel "
        "model.", choices=("motion", "elevation"))  # fmt: skip
    recording_topic: str = parameter("boom_tip",
        description="Topic to read from a bag: boom_tip, mru or wave_elevation (any namespace).")  # fmt: skip
    accept_implausible: bool = parameter(False,
        description="Take implausible figures in the files of sea, recording and RAOs as they are.")  # fmt: skip
    filter: ShapingFilterParameters = group(ShapingFilterParameters)
    vessel: VesselParameters = group(VesselParameters)
    crane: CraneMotionParameters = group(CraneMotionParameters)
    course: CourseParameters = group(CourseParameters)
    drift: DriftParameters = group(DriftParameters)
    mru: MruParameters = group(MruParameters)
    estimate: SeaStateEstimateParameters = group(SeaStateEstimateParameters)
    preview: PreviewParameters = group(PreviewParameters)

    def __post_init__(self) -> None:
        source = SOURCES[self.boom_tip_source]
        source.check(self)
        if source.has_sea and self.spectrum == SPECTRUM_FILE and not self.spectrum_file:
            raise ValueError("spectrum = file needs spectrum_file: name the file of the measured spectrum")
        if not source.has_sea and (self.course.turn_angle != 0.0 or self.course.speed_change != 0.0):
            raise ValueError(
                "a turn or change of speed needs a sea; it cannot be combined with boom_tip_source = "
                f"{self.boom_tip_source}"
            )
        if not source.has_sea and self.later_sea.duration > 0.0:
            raise ValueError(
                f"later_sea needs a sea; it cannot be combined with boom_tip_source = {self.boom_tip_source}"
            )
        if not source.has_sea and self.vessel.model == "fitted":
            raise ValueError(
                "vessel.model = fitted needs a sea spectrum to be fitted in; it cannot be combined with "
                ""
                "boom_tip_source = "
                f"{self.boom_tip_source}"
            )
        if source.has_sea and self.spectrum not in (SPECTRUM_FILE, *NEED_NO_PERIOD):
            self._refuse_breaking()
        if self.filter.states % 2:
            raise ValueError(f"filter.states must be even, got {self.filter.states}")

    def _refuse_breaking(self) -> None:
        """Raise ValueError for a sea, swell or later sea that cannot be: its waves would break."""
        seas: list[tuple[str, SeaParameters | SwellParameters | LaterSeaParameters]] = [("", self)]
        if self.spectrum == "ochi_hubble":
            seas.append(("swell: ", self.swell))
        if self.later_sea.duration > 0.0:
            seas.append(("later_sea: ", self.later_sea))
        for name, sea in seas:
            words = breaking_words(sea.significant_wave_height, sea.peak_period)
            if words:
                raise ValueError(f"{name}{words}")
