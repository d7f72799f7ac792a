"""The parameter set of the sea and vessel: sea, sources, vessel, crane and motion reference unit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from heave_node.crane.kinematics import JOINTS, CraneParameters
from heave_node.files.plausible import breaking_words
from heave_node.interface.faults import FaultParameters, MruFaultParameters
from heave_node.parameters import group, parameter
from heave_node.sensing.view import SensorParameters, View

from wave_vessel_node.registries import (
    AUTO,
    FILTER_FORMS,
    NEED_NO_PERIOD,
    SOURCES,
    SPECTRA,
    SPECTRUM_FILE,
    describe_choices,
)

if TYPE_CHECKING:
    from heave_node.numerics.arrays import Array


VESSEL_MODELS = ("second_order", "rao", "fitted", "direct")


@dataclass(frozen=True)
class VesselAnswer:
    """What sea and controller state alike of how the vessel answers the sea."""

    model: str = parameter("second_order",
        description="second_order (thesis Eq. 6.25), rao (table, 6 DOF; the controller uses fitted), fitted (second "
        "order, fitted to the table), direct.", choices=VESSEL_MODELS)  # fmt: skip
    gain: float = parameter(1.0, "", 1e-3, 10.0, "K_v: boom-tip heave per wave elevation at low frequency.")
    natural_frequency: float = parameter(0.9, "rad/s", 0.01, 10.0, "omega_v of the second-order vessel.")
    damping_ratio: float = parameter(0.4, "", 0.01, 5.0, "xi_v of the second-order vessel.")
    rao_file: str = parameter("",
        description="RAO table (models rao, fitted), .csv or Capytaine .nc; empty uses the hull form shipped with the "
        "package.")  # fmt: skip
    boom_tip_arm: tuple[float, ...] = parameter((-20.0, 10.0, 15.0), "m", -500.0, 500.0,
        "Boom tip from the vessel's reference point (x forward, y port, z up); models rao, fitted.",
        length=3)  # fmt: skip


@dataclass(frozen=True)
class VesselParameters(VesselAnswer):
    """How the vessel answers the sea."""

    pitch_gain: float = parameter(0.0, "", 0.0, 5.0,
        "Pitch of the second-order vessel per wave slope at low frequency (odometry, lever-arm error).")  # fmt: skip


@dataclass(frozen=True)
class LoadResponseParameters:
    """How the ship responds to the tension at the boom tip."""

    displacement: float = parameter(0.0, "kg", 0.0, None,
        "Mass of the ship, which cable tension moves in heave, roll and pitch; 0: no effect.")  # fmt: skip
    waterplane_area: float = parameter(1500.0, "m^2", 1.0, None, "Waterplane area.")
    metacentric_height: tuple[float, ...] = parameter((1.5, 110.0), "m", 0.01, None,
        "Metacentric heights: transverse, longitudinal.", length=2)  # fmt: skip
    natural_period: tuple[float, ...] = parameter((7.0, 12.0, 6.5), "s", 1.0, 100.0,
        "Natural periods of heave, roll and pitch.", length=3)  # fmt: skip
    damping_ratio: tuple[float, ...] = (0.3, 0.06, 0.3)  # damping ratios of heave, roll and pitch [-]


@dataclass(frozen=True)
class CourseParameters:
    """Heading and forward speed. The speed matters to model rao (encounter)."""

    heading: float = parameter(0.0, "rad", -6.3, 6.3, "Heading of the vessel from world x, anticlockwise.")
    speed: float = parameter(0.0, "m/s", 0.0, 15.0, "Forward speed.")


@dataclass(frozen=True)
class MruParameters:
    """The motion reference unit at the boom tip."""

    rate: float = parameter(0.0, "Hz", 0.0, 1000.0, "Rate of readings; 0: one per tick.")
    noise: float = parameter(0.01, "m", 0.0, 1.0, "White noise of heave: standard deviation of each reading.")
    rate_noise: float = parameter(0.01, "m/s", 0.0, 1.0,
        "White noise of heave rate: standard deviation of each reading.")  # fmt: skip
    measures_rate: bool = parameter(True,
        description="Measures heave rate and acceleration too; many MRUs give heave only (then NaN).")  # fmt: skip
    wander: float = parameter(0.0, "m", 0.0, 10.0,
        "Coloured error of heave (first-order Gauss-Markov process), standard deviation.")  # fmt: skip
    wander_time: float = parameter(60.0, "s", 0.01, 1e4,
        "Time constant of wander: a second colours the noise, a minute lets the zero drift.")  # fmt: skip
    resolution: float = parameter(0.0, "m", 0.0, 1.0, "Resolution of heave; 0: none.")
    rate_resolution: float = parameter(0.0, "m/s", 0.0, 1.0, "Resolution of heave rate; 0: none.")
    high_pass_period: float = parameter(0.0, "s", 0.0, 300.0,
        "Cut-off period of the second-order high-pass filter; 0: no filter.")  # fmt: skip
    high_pass_damping: float = 0.7071  # damping ratio of the high-pass filter [-]
    scale_error: float = parameter(0.0, "", -0.5, 0.5, "Relative scale error: 0.05 reads 5 % high.")
    lever_arm_error: tuple[float, ...] = parameter((0.0, 0.0, 0.0), "m", -10.0, 10.0,
        "Error of the lever arm entered in the MRU, vessel axes; it couples pitch and roll into heave.",
        length=3)  # fmt: skip
    latency: float = parameter(0.0, "s", 0.0, 5.0, "Delay from a reading's time stamp to its delivery.")
    stamp_error: float = parameter(0.0, "s", -5.0, 5.0,
        "Time by which the stamp is late: above 0, an additional hidden delay; below 0, readings are "
        "newer than their stamp.")  # fmt: skip
    # after a restart the status is settling for this many periods of the high-pass filter [-]
    settling_periods: float = 10.0
    # error of vertical acceleration right after a restart [m/s^2]; it decays with the period of the high-pass filter
    restart_bias: float = 0.02
    restart_duration: float = 2.0  # time for which the unit is silent while it restarts [s]
    faults: FaultParameters = group(MruFaultParameters)

    def __post_init__(self) -> None:
        """Refuse faults that the unit cannot have."""
        self.faults.check("mru.faults", "mru")


@dataclass(frozen=True)
class SeaStateEstimateParameters:
    """The running estimate of the sea state from the MRU record."""

    period: float = 30.0  # interval between estimates [s]
    window: float = 1800.0  # length of the record on which the estimate is based [s]
    segment: float = 200.0  # length of one Welch segment, half overlapping [s]


_WHERE = "after each of move_times; empty: unchanged."


@dataclass(frozen=True)
class PoseSensorParameters(SensorParameters):
    """Encoders of the crane's joints, read together. A scale, and a fault of one, is that of all of them."""

    rate: float = parameter(20.0, "Hz", 0.01, 1000.0, "Samples per second.")
    angle_resolution: float = 0.0  # step of the measured angles [rad]; 0 means none

    def view(self, truth: Array) -> View:
        """See the joints [rad], [m], and their rates [rad/s], [m/s], shape (8,)."""
        angle = self.angle_resolution
        return View(truth, 0.0, resolution=(angle, angle, angle, 0.0, 0.0, 0.0, 0.0, 0.0))


@dataclass(frozen=True)
class CraneMotionParameters(CraneParameters):
    """The crane of the simulated ship: it begins in the reference pose, moves by a programme, and measures its pose."""

    move_times: tuple[float, ...] = parameter((), "s", 0.0, None,
        "Simulated times at which moves of the crane begin, ascending.")  # fmt: skip
    move_slew: tuple[float, ...] = parameter((), "rad", -6.3, 6.3, f"Slew {_WHERE}")
    move_luff: tuple[float, ...] = parameter((), "rad", -1.6, 1.6, f"Luff {_WHERE}")
    move_knuckle: tuple[float, ...] = parameter((), "rad", -3.2, 3.2, f"Knuckle {_WHERE}")
    move_extension: tuple[float, ...] = parameter((), "m", -100.0, 100.0, f"Extension {_WHERE}")
    turn_rate: float = parameter(0.035, "rad/s", 1e-4, 1.0, "Largest rate of an angle during a move.")
    extension_rate: float = 0.2  # largest rate of the extension during a move [m/s]
    pose: PoseSensorParameters = group(PoseSensorParameters)

    def __post_init__(self) -> None:
        self.pose.faults.check("crane.pose.faults", "sensor")
        if list(self.move_times) != sorted(self.move_times):
            raise ValueError(f"crane.move_times must be ascending; got {list(self.move_times)}")
        for joint in JOINTS:
            targets = getattr(self, f"move_{joint}")
            if targets and len(targets) != len(self.move_times):
                raise ValueError(f"crane.move_{joint} must be empty or have as many values as crane.move_times")
        if self.move_times and not self.is_fitted:
            raise ValueError("crane.move_times needs a crane: give crane.boom_length")

    def largest_rate(self, joint: str) -> float:
        """Return the largest rate of a `joint` during a move [rad/s], [m/s]."""
        return self.extension_rate if joint == "extension" else self.turn_rate


FILTER_CHOICES = (AUTO, *FILTER_FORMS)


@dataclass(frozen=True)
class SwellParameters:
    """The second (low-frequency) system of an Ochi-Hubble sea."""

    significant_wave_height: float = parameter(1.0, "m", 0.0, 25.0, "Significant wave height of the swell alone.")
    peak_period: float = parameter(16.0, "s", 1.0, 40.0, "Peak period of the swell.")
    shape: float = parameter(3.0, "", 0.5, 20.0, "Ochi-Hubble shape of the swell; 1 is Bretschneider's.")


@dataclass(frozen=True)
class SeaParameters:
    """A sea that a few numbers describe; which spectrum takes which of them: see `registries`."""

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
        "s of cos^2s(angle/2) spreading about the direction; 0: long-crested.")  # fmt: skip


@dataclass(frozen=True)
class ShapingFilterParameters:
    """The shaping filter that the source `filter` drives with white noise."""

    form: str = parameter("auto",
        description=f"Shaping filter: {describe_choices(FILTER_FORMS)}; auto selects the best fit.",
        choices=FILTER_CHOICES)  # fmt: skip
    states: int = parameter(6, "", 4, 16, "States of a fitted filter; even.")


@dataclass(frozen=True)
class PreviewParameters:
    """The preview of the boom tip, as of waves that are measured up-wave or by radar."""

    time: float = parameter(0.0, "s", 0.0, 120.0, "Length of the boom-tip preview; 0: none.")
    noise: float = parameter(0.05, "m", 0.0, 10.0,
        "White error of the preview, 1 sigma; each predicted moment keeps its error.")  # fmt: skip


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
    spectrum_time: str = parameter("",
        description="Take the spectrum nearest to this time (UTC, like 1996-06-14T18:00); empty: the first one.",
    )  # fmt: skip
    recording_file: str = parameter("",
        description="Recording of the boom tip for boom_tip_source = file: CSV, or a bag (folder or .mcap) with topic "
        "boom_tip, else mru.")  # fmt: skip
    accept_implausible: bool = parameter(False,
        description="Accept implausible values in sea, motion and RAO files.")  # fmt: skip
    filter: ShapingFilterParameters = group(ShapingFilterParameters)
    vessel: VesselParameters = group(VesselParameters)
    load_response: LoadResponseParameters = group(LoadResponseParameters)
    crane: CraneMotionParameters = group(CraneMotionParameters)
    course: CourseParameters = group(CourseParameters)
    mru: MruParameters = group(MruParameters)
    estimate: SeaStateEstimateParameters = group(SeaStateEstimateParameters)
    preview: PreviewParameters = group(PreviewParameters)

    def __post_init__(self) -> None:
        source = SOURCES[self.boom_tip_source]
        source.check(self)
        if source.has_sea and self.spectrum == SPECTRUM_FILE and not self.spectrum_file:
            raise ValueError("spectrum = file needs spectrum_file: name the file of the measured spectrum")
        if not source.has_sea and self.later_sea.duration > 0.0:
            raise ValueError(
                f"later_sea needs a sea; it cannot be combined with boom_tip_source = {self.boom_tip_source}"
            )
        if not source.has_sea and self.vessel.model == "fitted":
            raise ValueError(
                "vessel.model = fitted needs a sea spectrum to be fitted in; it cannot be combined with "
                f"boom_tip_source = {self.boom_tip_source}"
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
