"""The baseline beside a run: the same scenario and seed under law industrial, in this process, kept beside the bag."""

from __future__ import annotations

import hashlib
import json
import zipfile
import zlib
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from cable_sim_node.errors import PlantError
from heave_bags.analyse.run_record import RunRecord
from heave_bags.mcap.reader import Progress, no_progress
from heave_bags.record.provenance import git_commit, versions
from heave_bags.signals import RunSignals, Signal
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.run.criteria import BASELINE_LAW
from heave_bringup.run.loop_signals import run_signals
from heave_bringup.run.records import Request
from heave_bringup.scenarios import Scenario
from heave_bringup.stored_scenario import parameters_of
from heave_node.files.given_files import whole_file
from heave_node.interface.codes import COMPENSATION_LOST as LOST
from heave_node.parameters import ParameterError
from winch_controller_node.model.lqr import DesignError

from heave_studies.kappa import scenario_of

SIMULATED = ("wave_vessel", "cable_sim", "virtual_winch")
"""Nodes that the baseline is the same without ROS as with it, if they were the suite's own."""
KEPT = ("unit_heave", "uncompensated_heave", "touchdown", "boom_tip_heave", "payout", "compensating")
"""Signals that the efficiencies are made from."""
LONGEST = 86_400.0
"""A record that ends later [s] is of no simulated run that anyone waits for."""
LARGEST_FILE = 1 << 28
"""Kept signals are smaller [byte]: a day of them."""


def baseline_signals(scenario: Scenario, progress: Progress = no_progress) -> RunSignals:
    """Return what a scenario comes to under the baseline law.

    Parameters
    ----------
    scenario : of the run
    progress : called with the share that is done, 0 to 1

    Raises DesignError where that law cannot be designed for it, PlantError where its cable cannot hang.
    """
    parameters: Mapping[str, object] = {
        **scenario.parameters,
        "winch_controller": replace(scenario.parameters["winch_controller"], law=BASELINE_LAW),
    }
    loop = loop_parameters(replace(scenario, parameters=parameters))
    ticks = round(loop.duration / loop.tick_period)
    record = ClosedLoop(loop).run(lambda tick, _: progress(tick / ticks) if tick % 20 == 0 else None)
    lost = (f"at {time:.0f} s: {alarm.values['reason']}" for time, alarm in record.alarms if alarm.code == LOST)
    return replace(run_signals(record, loop), lost=next(lost, "").partition(";")[0])


def add_to_record(record: RunRecord, request: Request, show: Callable[[str, float | None], None]) -> list[str]:
    """See `heave_bringup.run.records.AddToRecord`: adds the baseline."""
    words = f"{record.name}: computing the industrial baseline (skip: --no-baseline)"
    add_baseline(record, request.bag, request.scenario, lambda share: show(words, share))
    return []


def add_baseline(record: RunRecord, bag: Path, given: Scenario | None = None, progress: Progress = no_progress) -> None:
    """Put the baseline of a run into its record; where it cannot be computed, a note says why.

    It is computed once: its signals stay in a file beside the bag, for as long as scenario and software are the same.

    Parameters
    ----------
    record : of the run
    bag : folder that it was read from, with the scenario in it
    given : scenario of the run, where the bag carries none
    progress : called with the share that is done, 0 to 1, where there is work
    """
    scenario = scenario_of(bag) or given
    if scenario is not None and _is_its_own(record, scenario):
        record.signals.baseline = record.signals
        return
    reason = _why_unknown(record, scenario)
    if scenario is not None and not reason:
        scenario = replace(scenario, run=replace(scenario.run, duration=record.end))  # it may have been ended early
        try:
            record.signals.baseline = _kept_or_computed(scenario, bag, progress)
        except (DesignError, PlantError, ParameterError, ArithmeticError, ValueError, OSError) as error:  # of any bag
            reason = " ".join(str(error).split())
    if reason:
        record.notes.append(f"the baseline is unknown: {reason}")


def _is_its_own(record: RunRecord, scenario: Scenario) -> bool:
    """Return whether a run was one under the baseline law, by the suite's own controller."""
    return scenario.parameters["winch_controller"].law == BASELINE_LAW and not _replaced(record, scenario)


def _why_unknown(record: RunRecord, scenario: Scenario | None) -> str:
    """Return why the baseline of a run cannot be computed; "" where it can."""
    if scenario is None:
        return "the bag carries no scenario (--scenario names one)"
    not_simulated = [node for node in _replaced(record, scenario) if node in SIMULATED]
    if not_simulated:
        return f"{not_simulated[0]} was not simulated"
    return "" if 0.0 < record.end <= LONGEST else f"the record ends at {record.end:g} s"


def _replaced(record: RunRecord, scenario: Scenario) -> list[str]:
    """Return the nodes of a run in whose place hardware, a bag or another program took part."""
    entries = record.run.get("replaced", "").split()
    return [*scenario.run.external, *(entry.partition("=")[0] for entry in entries)]


def _kept_or_computed(scenario: Scenario, bag: Path, progress: Progress) -> RunSignals:
    file, digest = kept_at(bag), digest_of(scenario)
    kept = read_kept(file, digest)
    if kept is None:
        kept = baseline_signals(scenario, progress)
        with suppress(OSError):  # a folder that cannot be written: it is computed again next time
            keep(file, digest, kept)
    return kept


def digest_of(scenario: Scenario) -> str:
    """Return what identifies a baseline: every value of the scenario, versions and commit of the software."""
    text = json.dumps([parameters_of(scenario), versions(), git_commit()], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def kept_at(bag: Path) -> Path:
    """Return the file in which the baseline of the run in `bag` is kept."""
    bag = bag.resolve()
    return bag.with_name(f"{bag.name}.baseline.npz")


def keep(file: Path, digest: str, signals: RunSignals) -> None:
    """Keep a baseline in a file, of which no half is ever seen.

    Parameters
    ----------
    file : to be written
    digest : of scenario and software
    signals : of the baseline

    Raises OSError where it cannot be written.
    """
    parts: dict[str, Signal] = {name: getattr(signals, name) for name in KEPT}
    columns: dict[str, Any] = {name: np.stack((part.time, part.value)) for name, part in parts.items()}
    with whole_file(file) as unfinished, unfinished.open("wb") as stream:
        np.savez_compressed(stream, digest=np.array(digest), lost=np.array(signals.lost), **columns)


def read_kept(file: Path, digest: str) -> RunSignals | None:
    """Return the baseline kept in a `file`; None where it holds none of this `digest`, or is not whole."""
    try:
        with zipfile.ZipFile(file) as archive:
            if sum(part.file_size for part in archive.infolist()) > LARGEST_FILE:  # anyone may have written it
                return None
        with np.load(file, allow_pickle=False) as columns:
            if str(columns["digest"]) != digest:
                return None
            signals = RunSignals(lost=str(columns["lost"]))
            for name in KEPT:
                rows = columns[name].astype(float)
                if rows.ndim != 2 or len(rows) != 2:
                    return None
                setattr(signals, name, Signal(*rows))
            return signals
    # zlib.error of a damaged member; MemoryError of a head that promises terabytes
    except (OSError, ValueError, TypeError, LookupError, EOFError, MemoryError, zipfile.BadZipFile, zlib.error):
        return None
