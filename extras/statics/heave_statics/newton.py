"""Finding the three unknowns in a current: Newton with the exact Jacobian, and continuation where it diverges.

Drag turns with the cable and spoils the convexity that `dead_loads` rests on. Newton starts from the dead-load answer
and, where it diverges, follows the answer while the current is raised in steps (thesis 2.5, 2.7).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from cable_sim_node.errors import NoEquilibriumError
from heave_node.numerics.arrays import Array

from heave_statics.dead_loads import ACCEPTABLE, RELATIVE_TOLERANCE
from heave_statics.shape import StaticShape

NEWTON_LIMIT = 40
SMALLEST_STEP = 2.0**-8
"""Smallest step of the current in a continuation."""


Equations = Callable[[Array, float, Array | None], tuple[Array, Array, StaticShape] | None]
"""Three equations for three unknowns: (unknowns, current factor, guess of the segments' drag) to (residuals over scale,
their exact Jacobian, shape), None where impossible.
"""


def solve_newton(
    equations: Equations, guess: Array, factor: float, drag: Array | None = None
) -> tuple[Array, StaticShape] | None:
    """Solve at one strength of the current by damped Newton; return unknowns and shape, or None.

    Parameters
    ----------
    equations : what is solved
    guess : of the unknowns
    factor : strength of the current, 0 to 1
    drag : guess of the segments' drag, shape (n, 3) [N/m]; later each shape guesses it for the next, which keeps a
        hairpin bend, where several directions fit, on its branch
    """
    unknowns = guess.copy()
    state = equations(unknowns, factor, drag)
    for _ in range(NEWTON_LIMIT):
        if state is None:
            return None
        residual, jacobian, shape = state
        miss = float(np.linalg.norm(residual))
        if miss < RELATIVE_TOLERANCE:
            return unknowns, shape
        try:
            step = -np.linalg.solve(jacobian, residual)
        except np.linalg.LinAlgError:
            return None
        share, found = 1.0, None
        while share > 1e-4:
            trial = equations(unknowns + share * step, factor, shape.drag)
            if trial is not None and float(np.linalg.norm(trial[0])) < (1.0 - 0.1 * share) * miss:
                found = trial
                break
            share *= 0.5
        if found is None:
            return (unknowns, shape) if miss < ACCEPTABLE else None
        unknowns = unknowns + share * step
        state = found
    return None


def follow_current(equations: Equations, still: Array, what: str) -> StaticShape:
    """Return the answer at full current, reached by raising the current step by step.

    Each answer starts the next with the tangent of the last two; steps that fail are halved.

    Parameters
    ----------
    equations : what is solved
    still : the unknowns without any current
    what : the problem, for the message

    Raises
    ------
    NoEquilibriumError
        if the steps become too small; says at what share of the current the answer was lost.
    """
    direct = solve_newton(equations, still, 1.0)
    if direct is not None:
        return direct[1]
    begin = solve_newton(equations, still, 0.0)
    if begin is None:
        raise NoEquilibriumError(f"{what}: no equilibrium was found even without current")
    factor, step = 0.0, 0.125
    previous: tuple[float, Array] | None = None
    unknowns, shape = begin
    while factor < 1.0:
        target = min(1.0, factor + step)
        guess = unknowns
        if previous is not None:
            guess = unknowns + (unknowns - previous[1]) * (target - factor) / (factor - previous[0])
        drag = shape.drag if factor > 0.0 else None
        answer = solve_newton(equations, guess, target, drag)
        if answer is None and previous is not None:
            answer = solve_newton(equations, unknowns, target, drag)
        if answer is None:
            step *= 0.5
            if step < SMALLEST_STEP:
                raise NoEquilibriumError(
                    f"{what}: no equilibrium was found above {100.0 * factor:.3g} % of the current"
                )
            continue
        previous = (factor, unknowns)
        factor = target
        unknowns, shape = answer
        step = min(2.0 * step, 0.25)
    return shape
