"""Records for the adviser's tests: of numbers that a test gives, and drawn from a model that is then the truth."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from winch_controller_node.adviser.record import Excerpt
from winch_controller_node.core.estimation.observation_log import ROWS
from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.interface.observations import READING_COLUMNS, TICK_COLUMNS, Observations

DT = 0.05


def table_of_ticks(count, **columns):
    """Return a table of ticks, 0 but for the `columns` given; the brake is off."""
    table = np.zeros((count, len(TICK_COLUMNS)))
    for name, values in columns.items():
        table[:, TICK_COLUMNS.index(name)] = values
    return table


def table_of_readings(readings, rows=ROWS):
    """Return a table of `readings`, dicts of columns; by default delivered at their tick, used, without a share."""
    table = np.zeros((len(readings), len(READING_COLUMNS)))
    for place, reading in enumerate(readings):
        known = {"delivered": reading["tick"], "sigma": math.nan, "is_used": 1.0, "nis": math.nan} | reading
        known["row"] = rows.index(known["row"])
        table[place] = [known.get(name, 0.0) for name in READING_COLUMNS]
    return table


@pytest.fixture(scope="session")
def batch_of() -> Callable[..., Observations]:
    """Return a function that makes a batch of observations."""

    def batch(first, count=20, readings=(), epoch=0, beliefs=0, restated=(), **columns):
        ticks, read = table_of_ticks(count, **columns), table_of_readings(list(readings))
        return Observations(first, ticks, ROWS, read, epoch, beliefs, restated=restated)

    return batch


@pytest.fixture(scope="session")
def excerpt_of() -> Callable[..., Excerpt]:
    """Return a function that makes an excerpt of readings of the measurements `rows`."""

    def excerpt(count, readings=(), rows=ROWS, first=0, **columns):
        read = table_of_readings(list(readings), rows)
        return Excerpt(first, table_of_ticks(count, **columns), rows, read, DT)

    return excerpt


@pytest.fixture(scope="session")
def drawn_from() -> Callable[..., Excerpt]:
    """Return a function that draws a record from the model of a design, its winch sent a wave of its own.

    `change` takes measurement, value and tick of each reading and returns what is read in its place, None: nothing.
    """

    def drawn(design: ControllerDesign, seconds=60.0, *, seed=3, size=0.3, change=None, first=0) -> Excerpt:
        random, model = np.random.default_rng(seed), design.model
        n, count = model.order, round(seconds / DT)
        # the winch is as assumed: its noise stands for what no model of one has
        is_winch = np.array([name.startswith("payout") for name in model.state_names])
        noise = np.linalg.cholesky(model.noise_covariance + 1e-18 * np.eye(n)) * ~is_winch[:, None]
        x = np.linalg.cholesky(design.initial_covariance + 1e-12 * np.eye(n)) @ random.standard_normal(n)
        x[[model.state(name) for name in model.state_names if "payout" in name or name.endswith("bias")]] = 0.0
        commands = size * np.sin(0.55 * DT * np.arange(count) + 1.0)
        read, encoder = [], np.full(count, math.nan)
        for tick in range(count):
            x = model.A @ x + model.B[:, 0] * commands[tick] + noise @ random.standard_normal(n)
            for known in design.measurements:
                if known.sensor == "depth" and tick % 2:
                    continue
                value = float(known.row @ x + known.sigma * random.standard_normal())
                value = value if change is None else change(known.name, value, tick)
                if value is not None:
                    read.append({"tick": first + tick, "row": known.name, "value": value})
                    encoder[tick] = value if known.name == "payout" else encoder[tick]
        numbers = np.arange(first, first + count, dtype=float)
        columns = {"command": commands, "order_rate": commands, "sequence": numbers, "encoder": encoder}
        names = tuple(known.name for known in design.measurements)
        ticks = table_of_ticks(count, taken=numbers - 3.0, compensates=1.0, authority=1.0, **columns)
        return Excerpt(first, ticks, names, table_of_readings(read, names), DT)

    return drawn
