"""What a control law is: the class that each law derives from, what it is made for, and what it gives.

A law is one file with one class. The class itself says what the rest of the controller must know of it; `registry`
lists the classes, and nothing else names them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.laws.parts.effort import Effort
from winch_controller_node.laws.parts.loop_state import LoopState
from winch_controller_node.laws.parts.preview import PreviewUse
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.parameters.model import WeightParameters, WinchModelParameters


@dataclass(frozen=True, eq=False)
class LawDesign:
    """What a law is made for."""

    model: LinearModel  # augmented model, sampled at the ticks; one input, the command
    winch: WinchModelParameters  # the winch that it describes
    limits: WinchLimits  # of that winch, to be kept
    weights: WeightParameters  # of the quadratic cost
    # optimal gain of all states under these weights, u = -gain x, shape (n,); scheduled over length where there is a
    # schedule
    gain: Array
    # as `ControlLaw.own_gains` gives them, made beforehand; empty: the law makes them itself
    own_gains: Mapping[str, Array] = field(default_factory=dict)


class LawCommand(NamedTuple):
    """What a law asks for."""

    value: float  # share of the command that compensates [m/s] (or [m], first-order winch)
    status: str = ""  # of the solver, empty for laws without one
    iterations: int = 0  # of the solver
    active: tuple[str, ...] = ()  # limits that shape the plan


class ControlLaw(ABC):
    """A control law: from the state of the loop to one winch command per tick.

    Parameters
    ----------
    design : what the law is made for
    parameters : the law's own, of the type `parameters_type`; None where that is None

    Raises DesignError where the winch cannot be driven by this law.
    """

    # value of the parameter `law` that selects it; also the name of the group of its own parameters
    name: ClassVar[str]
    summary: ClassVar[str]  # what it does, in a few words
    parameters_type: ClassVar[type | None] = None  # class of its own parameters; None: it has none
    required_sensors: ClassVar[tuple[str, ...]] = ()  # must be in `sensors.use`
    moves_winch: ClassVar[bool] = True  # False: the brake stays on
    # it feeds the motion of the unit back, so that a wrong model can make the loop unstable
    feeds_back_unit: ClassVar[bool] = True
    # it keeps the limits of the winch by itself; other laws are given no more of a sea than the winch can follow
    keeps_limits: bool = False
    gain_names: ClassVar[tuple[str, ...]] = ()  # of the law's own gains, see `own_gains`

    def __init__(self, design: LawDesign, parameters: Any) -> None:
        del design, parameters
        # u = -gain x, shape (n,), where the law is a linear state feedback while no limit acts; else empty
        self.gain: Array = np.zeros(0)
        self.effort = Effort()  # what it asks of the winch, relative to a drum that follows the boom tip
        self.preview: PreviewUse | None = None  # what it wants of a preview of the boom tip; None: it uses none

    @classmethod
    def own_gains(cls, design: LawDesign, parameters: Any) -> dict[str, Array]:
        """Return its own gains for a `design` and its `parameters`, those of `gain_names`, shape (n,) each.

        To find them takes longer than a tick may.
        """
        del design, parameters
        return {}

    @abstractmethod
    def command(self, state: LoopState) -> LawCommand:
        """Return the command at `state`."""

    def take_limits(self, limits: WinchLimits) -> None:  # noqa: B027  # most laws leave them to the governor
        """Keep other limits from now on: the winch has been found to be weaker, or stronger, than assumed."""

    def prepare(self) -> None:  # noqa: B027  # most laws remember nothing
        """Make ready, between two ticks, what it takes to start again."""

    def reset(self) -> None:  # noqa: B027  # most laws remember nothing
        """Start again; a law that remembers nothing has nothing to do."""
