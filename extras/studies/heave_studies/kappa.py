"""The bounds in kappa for a recorded run: the best that its sensors and delay, and its winch, would have allowed."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
from heave_bags.analyse.run_record import RunRecord
from heave_bags.mcap.reader import Bag
from heave_bringup.run.records import Request
from heave_bringup.scenarios import Scenario, load_scenario
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError, build_parameters, describe, flatten
from winch_controller_node.design.bounds import (
    BOUND_STEP,
    actuator_bound,
    recorded_spectrum,
    sensor_bound,
)
from winch_controller_node.design.design import assumed_cable
from winch_controller_node.interface.sensors import (
    DepthModelParameters,
    EncoderModelParameters,
    LoadCellModelParameters,
    MruModelParameters,
    SensorsModelParameters,
)
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import (
    CableModelParameters,
    SeaModelParameters,
    VesselModelParameters,
    WinchModelParameters,
)


def add_to_record(record: RunRecord, request: Request, show: Callable[[str, float | None], None]) -> list[str]:
    """See `heave_bringup.run.records.AddToRecord`: adds the bounds of kappa."""
    show("bounds of kappa", None)
    add_bounds(record, request.bag, request.scenario)
    return []


def add_bounds(record: RunRecord, bag: Path, given: Scenario | None = None) -> None:
    """Put the bounds of a run into its record; where they cannot be computed kappa stays unknown, and a note says why.

    Parameters
    ----------
    record : of the run
    bag : folder that it was read from, with the scenario in it
    given : scenario of the run, where the bag carries none
    """
    scenario = scenario_of(bag) or given
    if scenario is None or not scenario.moves_winch:
        return
    if record.end <= scenario.run.transient:
        return  # the start-up says nothing about the controller
    try:
        tip = record.signals.boom_tip_heave.window(record.start, record.end)
        if tip.size < 2:
            raise DesignError("the bag holds no motion of the boom tip")
        time = np.arange(tip.time[0], tip.time[-1], BOUND_STEP)
        s_est, s_act = bounds_of(scenario, np.interp(time, tip.time, tip.value), BOUND_STEP)
    except (DesignError, ArithmeticError, ValueError) as error:  # a bag may carry any scenario, and any motion
        record.notes.append(f"kappa is unknown: {' '.join(str(error).split())}")
        return
    record.signals.sensor_bound, record.signals.actuator_bound = s_est, s_act


def bounds_of(scenario: Scenario, boom_tip: Array, step: float) -> tuple[float, float]:
    """Return s_est and s_act [m] of a scenario in the sea that its boom tip met.

    Winch, sensors, cable and unit are those of the simulators, the spectrum is the record's own: what the controller
    assumes, and how it is tuned, has no part in it but for the choice of sensors.

    Parameters
    ----------
    scenario : of the run
    boom_tip : its heave [m], shape (n,)
    step : from one sample to the next [s]

    Raises DesignError where there are no bounds, in words.
    """
    heave = boom_tip - boom_tip.mean()
    spectrum = recorded_spectrum(heave, step)
    truth = replace(
        true_parameters(scenario),
        sea=SeaModelParameters(
            significant_wave_height=max(4.0 * float(heave.std()), 0.01),
            peak_period=2.0 * math.pi / spectrum.peak_frequency,
        ),
        vessel=VesselModelParameters(model="direct"),
    )
    cable = assumed_cable(truth, truth.length)
    return sensor_bound(truth, scenario.run.tick_period, spectrum), actuator_bound(cable, truth.winch, heave, step)


def true_parameters(scenario: Scenario) -> WinchControllerParameters:
    """Return the parameters of a controller whose ship, winch, cable and sensors are those of `scenario`."""
    sea, plant, winch = (scenario.parameters[name] for name in ("wave_vessel", "cable_sim", "virtual_winch"))
    assumed: WinchControllerParameters = scenario.parameters["winch_controller"]
    known = {info.name for info in describe(WinchModelParameters)}
    drum = {name: value for name, value in flatten(winch).items() if name in known}
    mru, depth, cell = sea.mru, plant.sensors.depth, plant.sensors.load_cell
    linear = plant.model == "linear"
    return replace(
        assumed,
        length=plant.length,
        water_density=plant.water_density,
        gravity=plant.gravity,
        boom_tip_height=plant.boom_tip_height,
        cable=plant.cable,
        unit=plant.unit,
        cable_model=CableModelParameters(
            inertia=plant.linear.inertia if linear else 0.0, damping=plant.linear.damping if linear else 0.0
        ),
        winch=build_parameters(WinchModelParameters, drum, where="virtual_winch"),
        sensors=replace(
            SensorsModelParameters(use=assumed.sensors.use),
            mru=MruModelParameters(
                noise=mru.noise,
                rate_noise=mru.rate_noise,
                rate=mru.rate or 1.0 / scenario.run.tick_period,
                latency=mru.latency,
                high_pass_period=mru.high_pass_period,
            ),
            depth=DepthModelParameters(noise=depth.noise, rate=depth.rate, latency=depth.latency),
            encoder=EncoderModelParameters(noise=winch.encoder.resolution / math.sqrt(12.0)),
            load_cell=LoadCellModelParameters(noise=cell.noise, rate=cell.rate),
        ),
    )


def scenario_of(bag: Path) -> Scenario | None:
    """Return the scenario that the bag carries; None where it carries none that this version can read."""
    with suppress(ValueError):  # ParameterError among them
        return stored_scenario(Bag(bag))
    return None


def stored_scenario(bag: Bag, settings: Sequence[str] = ()) -> Scenario:
    """Return the scenario that a `bag` carries, with `settings` on top of it.

    Raises ParameterError where it carries none, and for one that this version cannot read.
    """
    texts = [content for name, content in bag.attachments.items() if name.endswith((".yaml", ".yml"))]
    if not texts:
        raise ParameterError(f"{bag.path}: carries no scenario: what its controller assumed is not known")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scenario.yaml"
        path.write_bytes(texts[0])
        return load_scenario(str(path), settings=settings, needs_files=False)
