"""The parameter set of the sea and vessel."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.faults import FaultParameters
from heave_node.parameters import group, parameter
from heave_node.registry import describe_choices

from wave_vessel_node.sea_registry import AUTO, FILTER_FORMS, SPECTRA, SPECTRUM_FILE
from wave_vessel_node.source_registry import SOURCES

VESSEL_MODELS = ("second_order", "rao", "fitted", "direct")
FILTER_CHOICES = (AUTO, *FILTER_FORMS)


@dataclass(frozen=True)
class SwellParameters:
    """The second (low-frequency) system of an Ochi-Hubble sea."""

    significant_wave_height: float = parameter(
        1.0, unit="m", minimum=0.0, maximum=25.0, description="Significant wave height of the swell alone."
    )
    peak_period: float = parameter(16.0, unit="s", minimum=1.0, maximum=40.0, description="Peak period of the swell.")
    shape: float = parameter(
        3.0, unit="", minimum=0.5, maximum=20.0, description="Ochi-Hubble shape of the swell; 1 is Bretschneider's."
    )


@dataclass(frozen=True)
class SeaParameters:
    """A sea that a few numbers describe; which spectrum takes which of them: see `sea_registry`."""

    spectrum: str = parameter(
        "bretschneider",
        unit="",
        choices=tuple(SPECTRA),
        description=f"Spectrum of the sea: {describe_choices(SPECTRA)}.",
    )
    significant_wave_height: float = parameter(
        1.0,
        unit="m",
        minimum=0.0,
        maximum=25.0,
        description="Significant wave height (of the wind sea in ochi_hubble).",
    )
    peak_period: float = parameter(
        8.0,
        unit="s",
        minimum=1.0,
        maximum=40.0,
        description="Peak period (of the wind sea in ochi_hubble); pierson_moskowitz takes it from the height.",
    )
    peak_enhancement: float = parameter(
        3.3, unit="", minimum=1.0, maximum=10.0, description="gamma of the JONSWAP spectrum."
    )
    shape: float = parameter(
        1.0, unit="", minimum=0.5, maximum=20.0, description="Ochi-Hubble shape of the wind sea; 1 is Bretschneider's."
    )
    swell: SwellParameters = group(SwellParameters)


@dataclass(frozen=True)
class SpreadingParameters:
    """Directional spreading of the wave energy."""

    exponent: float = parameter(
        0.0,
        unit="",
        minimum=0.0,
        maximum=500.0,
        description="s of cos^2s(angle/2) spreading about the direction; 0 means long-crested.",
    )


@dataclass(frozen=True)
class ShapingFilterParameters:
    """The shaping filter that the source `filter` drives with white noise."""

    form: str = parameter(
        "auto",
        unit="",
        choices=FILTER_CHOICES,
        description=f"Shaping filter: {describe_choices(FILTER_FORMS)}; auto takes the best.",
    )
    states: int = parameter(6, unit="", minimum=4, maximum=16, description="States of a fitted filter; even.")


@dataclass(frozen=True)
class VesselParameters:
    """How the vessel answers the sea."""

    model: str = parameter(
        "second_order",
        unit="",
        choices=VESSEL_MODELS,
        description="second_order (thesis Eq. 6.25), rao (table, 6 DOF), fitted (second order, to the rao), direct.",
    )
    natural_frequency: float = parameter(
        0.9, unit="rad/s", minimum=0.01, maximum=10.0, description="omega_v of the second-order vessel."
    )
    damping_ratio: float = parameter(
        0.4, unit="", minimum=0.01, maximum=5.0, description="xi_v of the second-order vessel."
    )
    gain: float = parameter(
        1.0, unit="", minimum=0.0, maximum=10.0, description="K_v: boom-tip heave per wave elevation at low frequency."
    )
    pitch_gain: float = parameter(
        0.0,
        unit="",
        minimum=0.0,
        maximum=5.0,
        description="Pitch of the second-order vessel per wave slope at low frequency (odometry, lever-arm error).",
    )
    rao_file: str = parameter(
        "",
        unit="",
        description="RAO table (models rao, fitted), .csv or Capytaine .nc; empty is the hull form shipped.",
    )
    boom_tip_arm: tuple[float, ...] = parameter(
        (-20.0, 10.0, 15.0),
        unit="m",
        minimum=-500.0,
        maximum=500.0,
        length=3,
        description="Boom tip from the vessel's reference point (x forward, y port, z up); models rao, fitted.",
    )


@dataclass(frozen=True)
class CourseParameters:
    """Heading and forward speed, and one change of them. They matter to model rao (encounter) and to the MRU (turn)."""

    heading: float = parameter(
        0.0, unit="rad", minimum=-6.3, maximum=6.3, description="Heading of the vessel from world x, anticlockwise."
    )
    speed: float = parameter(0.0, unit="m/s", minimum=0.0, maximum=15.0, description="Forward speed.")
    turn_start: float = parameter(0.0, unit="s", minimum=0.0, description="Time at which the turn begins.")
    turn_angle: float = parameter(
        0.0, unit="rad", minimum=-20.0, maximum=20.0, description="Change of heading; 6.2832 is a loop turn, 0 none."
    )
    turn_rate: float = parameter(
        0.01, unit="rad/s", minimum=1e-4, maximum=0.2, description="Largest rate of turn during the change of heading."
    )
    speed_change_start: float = parameter(0.0, unit="s", minimum=0.0, description="Time at which the speed changes.")
    speed_change: float = parameter(
        0.0, unit="m/s", minimum=-15.0, maximum=15.0, description="Change of the forward speed; 0 is none."
    )
    speed_change_duration: float = parameter(
        60.0, unit="s", minimum=1.0, description="How long the change of speed takes."
    )


@dataclass(frozen=True)
class DriftParameters:
    """Slow drift of the vessel on its position keeping."""

    standard_deviation: tuple[float, ...] = parameter(
        (0.0, 0.0),
        unit="m",
        minimum=0.0,
        maximum=100.0,
        length=2,
        description="Standard deviation of the slow drift in surge and sway; 0 is none.",
    )
    period: float = parameter(
        120.0, unit="s", minimum=20.0, maximum=1000.0, description="Natural period of the drift on its mooring or DP."
    )
    damping_ratio: float = parameter(
        0.15, unit="", minimum=0.02, maximum=1.0, description="Damping ratio of the slow drift."
    )


@dataclass(frozen=True)
class MruParameters:
    """The motion reference unit at the boom tip."""

    rate: float = parameter(
        0.0, unit="Hz", minimum=0.0, maximum=1000.0, description="Rate of readings; 0 is one in every tick."
    )
    noise: float = parameter(
        0.01, unit="m", minimum=0.0, maximum=1.0, description="White noise of heave, one standard deviation a reading."
    )
    rate_noise: float = parameter(
        0.01, unit="m/s", minimum=0.0, maximum=1.0, description="White noise of heave rate, one standard deviation."
    )
    high_pass_period: float = parameter(
        0.0,
        unit="s",
        minimum=0.0,
        maximum=300.0,
        description="Cut-off period of the second-order high-pass; 0 is none.",
    )
    high_pass_damping: float = parameter(
        0.7071, unit="", minimum=0.2, maximum=2.0, description="Damping ratio of the high-pass."
    )
    scale_error: float = parameter(
        0.0, unit="", minimum=-0.5, maximum=0.5, description="Relative error of scale: 0.05 reads 5 % too much."
    )
    lever_arm_error: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        unit="m",
        minimum=-10.0,
        maximum=10.0,
        length=3,
        description="Error of the lever arm entered in the unit, vessel axes; it lets pitch and roll into heave.",
    )
    latency: float = parameter(
        0.0, unit="s", minimum=0.0, maximum=5.0, description="A reading arrives this late, honestly stamped."
    )
    stamp_error: float = parameter(
        0.0, unit="s", minimum=0.0, maximum=5.0, description="Further delay that the stamp does not tell."
    )
    settling_periods: float = parameter(
        10.0,
        unit="",
        minimum=0.0,
        maximum=50.0,
        description="After a restart or a turn the status is settling for this many high-pass periods.",
    )
    restart_bias: float = parameter(
        0.02,
        unit="m/s^2",
        minimum=-1.0,
        maximum=1.0,
        description="Error of vertical acceleration right after a restart; it fades with the high-pass period.",
    )
    turn_sensitivity: float = parameter(
        0.01,
        unit="",
        minimum=-1.0,
        maximum=1.0,
        description="Error of vertical acceleration per centripetal acceleration in a turn (tilt of the vertical).",
    )
    restart_duration: float = parameter(
        2.0, unit="s", minimum=0.0, maximum=600.0, description="Silence of the unit while it restarts."
    )
    faults: FaultParameters = group(FaultParameters)

    def __post_init__(self) -> None:
        """Refuse faults that the unit cannot have."""
        self.faults.check("mru.faults", "mru")


@dataclass(frozen=True)
class SeaStateEstimateParameters:
    """The running estimate of the sea state from the MRU record."""

    window: float = parameter(
        1800.0, unit="s", minimum=120.0, maximum=21600.0, description="Length of record the estimate stands on."
    )
    segment: float = parameter(
        200.0, unit="s", minimum=30.0, maximum=3600.0, description="Length of one Welch segment (half overlapping)."
    )
    period: float = parameter(
        30.0, unit="s", minimum=1.0, maximum=3600.0, description="A new estimate is made this often."
    )

    def __post_init__(self) -> None:
        if self.window < 2 * self.segment:
            raise ValueError(
                f"estimate.window ({self.window:g} s) must hold at least two of estimate.segment ({self.segment:g} s)"
            )


@dataclass(frozen=True)
class WaveVesselParameters(SeaParameters):
    """Everything of `wave_vessel`: the sea, the vessel, its course and the motion reference unit."""

    boom_tip_source: str = parameter(
        "spectrum",
        unit="",
        choices=tuple(SOURCES),
        description=f"What moves the boom tip: {describe_choices(SOURCES)}.",
    )
    boom_tip_height: float = parameter(
        0.0, unit="m", minimum=-100.0, maximum=200.0, description="Mean height of the boom tip above still water."
    )
    ramp: float = parameter(
        60.0,
        unit="s",
        minimum=0.0,
        maximum=3600.0,
        description="All motion grows from rest over this time (twice differentiable); 0 starts in full motion.",
    )
    amplitude: tuple[float, ...] = parameter(
        (0.0, 0.0, 1.0),
        unit="m",
        minimum=-50.0,
        maximum=50.0,
        length=3,
        description="Source regular: boom tip moves as a_i sin(2 pi t / period) along world x, y, z.",
    )
    period: float = parameter(10.0, unit="s", minimum=0.5, maximum=1000.0, description="Period of the source regular.")
    spectrum: str = parameter(
        "bretschneider",
        unit="",
        choices=(*SPECTRA, SPECTRUM_FILE),
        description=f"Spectrum of the sea: {describe_choices(SPECTRA)}, {SPECTRUM_FILE} (measured).",
    )
    direction: float = parameter(
        3.141592653589793,
        unit="rad",
        minimum=-6.3,
        maximum=6.3,
        description="Direction the waves travel to, from world x, anticlockwise; pi meets heading 0 head on.",
    )
    spreading: SpreadingParameters = group(SpreadingParameters)
    components: int = parameter(
        800, unit="", minimum=1, maximum=20000, description="Number of components of the source spectrum."
    )
    spectrum_file: str = parameter(
        "",
        unit="",
        description="Measured spectrum for spectrum = file: NDBC real-time or historical, or what wavespectra reads.",
    )
    spectrum_record: int = parameter(
        0, unit="", minimum=0, description="Which usable spectrum of the file, counted from 0 in order of time."
    )
    spectrum_time: str = parameter(
        "", unit="", description="Or the spectrum nearest to this time (UTC, like 1996-06-14T18:00); empty: by record."
    )
    recording_file: str = parameter(
        "", unit="", description="Recording for boom_tip_source = file: CSV, or a bag (folder or .mcap)."
    )
    recording_kind: str = parameter(
        "motion",
        unit="",
        choices=("motion", "elevation"),
        description="What the recording holds: motion of the boom tip, or wave elevation that goes through the vessel.",
    )
    recording_topic: str = parameter(
        "boom_tip", unit="", description="Topic to take from a bag: boom_tip, mru or wave_elevation (any namespace)."
    )
    filter: ShapingFilterParameters = group(ShapingFilterParameters)
    vessel: VesselParameters = group(VesselParameters)
    course: CourseParameters = group(CourseParameters)
    drift: DriftParameters = group(DriftParameters)
    mru: MruParameters = group(MruParameters)
    estimate: SeaStateEstimateParameters = group(SeaStateEstimateParameters)

    def __post_init__(self) -> None:
        source = SOURCES[self.boom_tip_source]
        source.check(self)
        if source.has_sea and self.spectrum == SPECTRUM_FILE and not self.spectrum_file:
            raise ValueError("spectrum = file needs spectrum_file: name the file of the measured spectrum")
        if not source.has_sea and (self.course.turn_angle != 0.0 or self.course.speed_change != 0.0):
            raise ValueError(
                f"a turn or change of speed goes with a sea, not with boom_tip_source = {self.boom_tip_source}"
            )
        if not source.has_sea and self.vessel.model == "fitted":
            raise ValueError(
                "vessel.model = fitted is fitted in the sea of a spectrum, not with boom_tip_source = "
                f"{self.boom_tip_source}"
            )
        if self.filter.states % 2:
            raise ValueError(f"filter.states must be even, got {self.filter.states}")
