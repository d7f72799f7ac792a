"""Linearised vertical motion of unit and cable: transfer functions, natural frequencies, resonance map, two-state fit.

Exact in space: every uniform piece of cable is a bar solved in closed form, pieces are joined by their tension, so that
there is no mesh. Quadratic drag enters as the equivalent linear damping that dissipates the same energy in a harmonic
cycle, 8/(3 pi) * drag * velocity amplitude, found by iteration with the local amplitude.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy
from heave_node.numerics.arrays import Array, ComplexArray
from numpy.typing import ArrayLike

from cable_sim_node.errors import LinearisationError
from cable_sim_node.physics.drag import HARMONIC_DRAG
from cable_sim_node.vertical.axial_line import AxialLine, AxialPiece

DRAG_PIECES = 12
"""Pieces along the cable in each of which the drag's linearisation amplitude is constant."""

DRAG_ITERATIONS = 60

RESONANCES = np.geomspace(0.1, 10.0, 120)
"""Middle of the band over the resonance of a two-state model, at which its fit may begin."""

DAMPING_RATIOS = np.array([1e-3, 0.03, 0.3])
"""b times the middle of the band at which it may begin."""

NEAR_ROOT = 1e-4
"""Relative distance from a natural frequency at which the slope there is taken."""


@dataclass(frozen=True)
class HeaveTransfer:
    """Transfer function from boom-tip heave at a fixed length."""

    omegas: Array  # [rad/s]
    unit_heave: ComplexArray  # complex, unit heave over boom-tip heave (positive phase leads) [-]
    top_tension: ComplexArray  # complex, top tension over boom-tip heave [N/m]


@dataclass(frozen=True)
class ResonanceMap:
    """Amplitudes over length and frequency."""

    lengths: Array  # [m], shape (n,)
    omegas: Array  # [rad/s], shape (k,)
    unit_heave: Array  # over boom-tip heave, shape (n, k) [-]
    top_tension: Array  # over boom-tip heave, shape (n, k) [N/m]


class FirstMode(NamedTuple):
    """Unit heave over boom-tip heave by the first mode, what is above it static: 1 - P + P/(1 - a w^2).

    Modal superposition of a base excitation (Clough and Penzien, Dynamics of Structures, section 12-7).
    """

    a: float  # one over the square of the natural frequency [s^2]
    participation: float  # P, the mode's share of the unit in a motion of the boom tip [-]


@dataclass(frozen=True)
class TwoStateModel:
    """a x'' + b x' + x = x0 (thesis Eq. 6.2): x unit heave, x0 boom-tip heave."""

    a: float  # [s2]
    b: float  # [s]
    error: float  # root mean square of the weighted difference of transfer functions over that of the exact one [-]

    def transfer(self, omegas: ArrayLike) -> ComplexArray:
        """Return 1/(1 - a w^2 + i b w) at the frequencies `omegas` [rad/s]."""
        return _two_state_transfer(self.a, self.b, np.asarray(omegas, dtype=np.float64))


def _two_state_transfer(a: float | Array, b: float | Array, omega: Array) -> ComplexArray:
    return np.asarray(1.0 / (1.0 - a * omega**2 + 1j * b * omega))


def heave_transfer_function(
    line: AxialLine, length: float, omegas: ArrayLike, *, amplitude: float | ArrayLike = 0.0
) -> HeaveTransfer:
    """Return the transfer functions boom tip to unit heave and to top tension.

    Parameters
    ----------
    line : cable and unit
    length : unstretched length out [m]
    omegas : [rad/s], positive
    amplitude : boom-tip amplitude at each frequency [m] about which drag is linearised; 0 leaves drag out, which is
        infinite at a resonance unless the cable has internal damping

    Raises
    ------
    LinearisationError
        for a length or a frequency that is not positive.
    """
    omega = np.atleast_1d(np.asarray(omegas, dtype=np.float64))
    if not (length > 0.0 and np.all(np.isfinite(omega)) and np.all(omega > 0.0)):
        raise LinearisationError("length and all frequencies must be positive and finite")
    tip = np.broadcast_to(np.asarray(amplitude, dtype=np.float64), omega.shape)
    pieces = [part for piece in line.pieces(length) for part in divide(piece, length / DRAG_PIECES)]
    drags = [line.unit.drag, *(clump.drag for clump in line.clumps), *(section.drag for section in line.sections)]
    has_drag = bool(np.any(tip > 0.0)) and max(drags) > 0.0
    speeds = np.zeros((len(pieces) + 1, len(omega)))
    if has_drag:
        speeds[:] = omega * tip
        for _ in range(DRAG_ITERATIONS):
            motion = march(line, pieces, omega, speeds)
            heave = np.abs(motion.heave) / np.abs(motion.boom_tip) * tip
            local = omega * np.concatenate((heave[:1], 0.5 * (heave[1:] + heave[:-1])))
            change = float(np.max(np.abs(local - speeds)))
            # the geometric mean settles the resonance, where amplitude goes as 1/sqrt(damping)
            speeds = np.sqrt(speeds * local)
            if change < 1e-9 * (1.0 + float(speeds.max())):
                break
    motion = march(line, pieces, omega, speeds)
    return HeaveTransfer(omega, 1.0 / motion.boom_tip, motion.top_tension / motion.boom_tip)


@dataclass(frozen=True)
class March:
    """What a unit heave of 1 is with along the cable."""

    heave: ComplexArray  # at the joints, from the unit upwards, shape (places, k) [-]
    boom_tip: ComplexArray  # motion at the boom tip, above what gives in the rope path, shape (k,) [-]
    top_tension: ComplexArray  # shape (k,) [N/m]


def divide(piece: AxialPiece, size: float) -> list[AxialPiece]:
    """Cut a `piece` into equal pieces of at most `size` [m]; the clumps stay at the lower end."""
    count = max(1, math.ceil(piece.length / size - 1e-9))
    part = replace(piece, length=piece.length / count)
    return [part, *[replace(part, clumps=())] * (count - 1)]


def march(line: AxialLine, pieces: list[AxialPiece], omega: Array, speeds: Array) -> March:
    """Carry displacement and tension from the unit (displacement 1) to the top, piece by piece in closed form.

    Parameters
    ----------
    line : cable and unit
    pieces : of the cable, from the unit upwards
    omega : [rad/s], shape (k,)
    speeds : harmonic speed amplitudes of unit and pieces, for their drag [m/s], shape (pieces + 1, k)
    """
    displacement = np.ones(len(omega), dtype=np.complex128)
    unit_damping = HARMONIC_DRAG * line.unit.drag * speeds[0]
    tension = -line.unit.inertia * omega**2 + 1j * omega * unit_damping
    heave = [displacement]
    for piece, speed in zip(pieces, speeds[1:], strict=True):
        for clump in piece.clumps:
            drag = 1j * omega * HARMONIC_DRAG * clump.drag * speed
            tension = tension + (drag - clump.inertia * omega**2) * displacement
        stiffness = piece.axial_stiffness * (1.0 + 1j * omega * piece.damping_time)
        load = piece.mass * omega**2 - 1j * omega * HARMONIC_DRAG * piece.drag * speed
        number = np.sqrt(load / stiffness)
        angle = number * piece.length
        cosine, shape = np.cos(angle), np.sinc(angle / np.pi) * piece.length
        displacement, tension = (
            cosine * displacement + shape / stiffness * tension,
            -load * shape * displacement + cosine * tension,
        )
        heave.append(displacement)
    return March(np.array(heave), displacement + tension / line.top_stiffness, tension)


def drag_at_unit(line: AxialLine, length: float) -> float:
    """Return the drag of unit and cable over the square of the unit's speed [N s2/m2].

    The cable moves in proportion to its stretch below the held top, as it does below its first resonance; what each
    part takes in power counts. `line` is out by `length` [m].
    """
    pieces = line.pieces(length)
    stretch = sum(piece.length / piece.axial_stiffness for piece in pieces)
    drag, low = line.unit.drag, 1.0
    for piece in pieces:
        high = max(low - piece.length / piece.axial_stiffness / stretch, 0.0)
        drag += sum(clump.drag for clump in piece.clumps) * low**3
        # the mean of the cube of what falls evenly from low to high
        drag += piece.drag * piece.length * (low**3 + low**2 * high + low * high**2 + high**3) / 4.0
        low = high
    return drag


def natural_frequencies(line: AxialLine, length: float, count: int) -> Array:
    """Return the lowest undamped natural frequencies of heave with the top held [rad/s], ascending.

    Between two roots the top displacement per unit displacement changes sign, and there is one root for each half wave
    along the cable, so none is missed.

    Parameters
    ----------
    line : cable and unit
    length : unstretched length out [m]
    count : how many

    Raises
    ------
    LinearisationError
        for a length or a count that is not positive, or a coefficient that is not a number.
    """
    if not (length > 0.0 and count >= 1):
        raise LinearisationError("length must be positive and count at least 1")
    pieces = _undamped(line.pieces(length))
    speeds = np.zeros((len(pieces) + 1, 1))

    def top(omega: float) -> float:
        return float(march(line, pieces, np.array([omega]), speeds).boom_tip.real[0])

    travel = sum(piece.length * math.sqrt(piece.mass / piece.axial_stiffness) for piece in pieces)
    compliance = 1.0 / line.top_stiffness + sum(piece.length / piece.axial_stiffness for piece in pieces)
    mass = sum(piece.mass * piece.length for piece in pieces)
    mass += line.unit.inertia + sum(clump.inertia for clump in line.clumps)
    step = 0.05 * min(1.0 / math.sqrt(compliance * mass), math.pi / travel)
    if not step > 0.0:
        raise LinearisationError("a coefficient of cable or unit is not a number")
    roots: list[float] = []
    low, value = 0.0, 1.0
    while len(roots) < count:
        high = low + step
        next_value = top(high)
        if value * next_value <= 0.0:
            roots.append(float(scipy.optimize.brentq(top, low, high, xtol=1e-14, rtol=1e-13)))
            step = 0.05 * math.pi / travel
        low, value = high, next_value
    return np.array(roots)


def _undamped(pieces: list[AxialPiece]) -> list[AxialPiece]:
    return [replace(piece, damping_time=0.0) for piece in pieces]


def first_mode(line: AxialLine, length: float) -> FirstMode:
    """Return how a unit below a boom tip moves by its first mode; `line` is out by `length` [m]."""
    omega = float(natural_frequencies(line, length, 1)[0])
    pieces = _undamped(line.pieces(length))
    near = omega * np.array([1.0 - NEAR_ROOT, 1.0 + NEAR_ROOT])
    below, above = march(line, pieces, near, np.zeros((len(pieces) + 1, 2))).boom_tip.real
    # near its root the motion of the top that the unit takes goes as (1 - w^2/w_1^2) over the participation
    return FirstMode(1.0 / omega**2, float(4.0 * NEAR_ROOT / (below - above)))


def mode_shape(line: AxialLine, length: float, omega: float, points: int = 50) -> tuple[Array, Array]:
    """Return a free vibration's labels counted from the unit [m], and the heave there, largest 1.

    Parameters
    ----------
    line : cable and unit
    length : unstretched length out [m]
    omega : a natural frequency [rad/s]
    points : labels; there are some more where the cable has joints
    """
    pieces = [part for piece in _undamped(line.pieces(length)) for part in divide(piece, length / points)]
    labels = np.concatenate(([0.0], np.cumsum([piece.length for piece in pieces])))
    moved = march(line, pieces, np.array([omega]), np.zeros((len(pieces) + 1, 1)))
    shape = moved.heave[:, 0].real
    return labels, shape / float(np.max(np.abs(shape)))


def resonance_map(
    line_at: Callable[[float], AxialLine], lengths: ArrayLike, omegas: ArrayLike, *, amplitude: float = 0.0
) -> ResonanceMap:
    """Return how unit and top tension answer at every length and frequency: where a lowering meets its resonances.

    Parameters
    ----------
    line_at : gives cable and unit at a length out [m]
    lengths : unstretched lengths out [m]
    omegas : [rad/s], positive
    amplitude : of the boom tip [m], see `heave_transfer_function`
    """
    spans = np.atleast_1d(np.asarray(lengths, dtype=np.float64))
    answers = [heave_transfer_function(line_at(x), x, omegas, amplitude=amplitude) for x in spans.tolist()]
    return ResonanceMap(
        lengths=spans,
        omegas=answers[0].omegas,
        unit_heave=np.array([np.abs(answer.unit_heave) for answer in answers]),
        top_tension=np.array([np.abs(answer.top_tension) for answer in answers]),
    )


def resonant_length(line: AxialLine, omega: float) -> float:
    """Return the rough length of cable [m] at which `omega` [rad/s] is in resonance: EA/(w^2 (M + Ma)) (thesis 3.3.5).

    Neglects the own mass of the cable of `line`; of several sections it takes the uppermost.
    """
    if not omega > 0.0:
        raise LinearisationError("omega must be positive")
    return line.sections[-1].axial_stiffness / (omega**2 * line.unit.inertia)


def fit_two_state(omegas: ArrayLike, unit_heave: ArrayLike, *, weights: ArrayLike | None = None) -> TwoStateModel:
    """Return the a, b of thesis Eq. 6.2 whose transfer function is nearest to `unit_heave` in least squares.

    Parameters
    ----------
    omegas : [rad/s]
    unit_heave : complex transfer function boom tip to unit at `omegas`
    weights : of each frequency, for example the amplitude spectrum of the boom tip; None for equal

    Raises
    ------
    LinearisationError
        if fewer than two frequencies are given, or they differ in number, or the unit stands still.
    """
    omega = np.asarray(omegas, dtype=np.float64)
    exact = np.asarray(unit_heave, dtype=np.complex128)
    weight = np.ones_like(omega) if weights is None else np.asarray(weights, dtype=np.float64)
    if not (len(omega) > 1 and exact.shape == omega.shape == weight.shape and np.any(np.abs(weight * exact) ** 2)):
        raise LinearisationError(
            "a two-state fit needs two frequencies or more, each with a response and a weight, and a unit that moves"
        )

    def difference(guess: Array) -> Array:
        error = weight * (_two_state_transfer(guess[0], guess[1], omega) - exact)
        return np.concatenate((error.real, error.imag))

    # with every resonance but the nearest there is a minimum beside the band, where the unit moves the other way
    middle = float(weight @ omega / np.sum(weight))
    starts = np.array(list(itertools.product(RESONANCES**2 / middle**2, DAMPING_RATIOS / middle)))
    responses = _two_state_transfer(starts[:, :1], starts[:, 1:], omega)
    start = starts[np.argmin(np.sum(np.abs(weight * (responses - exact)) ** 2, axis=1))]
    fit = scipy.optimize.least_squares(difference, start, x_scale=start, bounds=(0.0, np.inf))
    size = float(np.sqrt(np.sum(np.abs(weight * exact) ** 2)))
    return TwoStateModel(float(fit.x[0]), float(fit.x[1]), float(np.sqrt(2.0 * fit.cost)) / size)
