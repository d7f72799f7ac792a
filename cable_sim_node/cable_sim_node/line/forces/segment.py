"""Tension of a segment with its derivatives, and symmetric 3 x 3 blocks, as xx, xy, xz, yy, yz, zz.

Nothing here branches, so that a loop over segments is compiled to vector instructions.
"""

from __future__ import annotations

import math

from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.physics.drag import Vector
from cable_sim_node.physics.tension_law import stiffening, tangent_stiffness

Block = tuple[float, float, float, float, float, float]


@inner_kernel
def tension_of(
    stiffness: float, q: float, c: float, damping: float, strain: float, strain_rate: float
) -> tuple[float, float, float]:
    """Return tension [N], its derivative by strain and by strain rate.

    Parameters
    ----------
    stiffness, q, c : of the tension law, see `physics.tension_law`
    damping : internal damping [N s]
    strain, strain_rate : [-], [1/s]

    A slack segment carries none. Internal damping adds T_e r/sqrt(1 + r^2) to the elastic tension T_e, with r the
    damping force over T_e: it stays below T_e and so never pushes, and a line that comes taut meets no step in force.
    """
    # T = T_e (1 + f/s), f = d e', s = sqrt(T_e^2 + f^2): what T_e r/sqrt(1 + r^2) is, with r = f/T_e
    elastic = stiffness * strain * stiffening(q, c, strain)
    slope = tangent_stiffness(stiffness, q, c, strain)
    friction = damping * strain_rate
    per_size = 1.0 / math.sqrt(elastic * elastic + friction * friction)
    cosine, sine = elastic * per_size, friction * per_size
    is_taut = strain > 0.0
    tension = elastic + elastic * sine if is_taut else 0.0
    by_strain = slope + slope * sine * sine * sine if is_taut else 0.0
    by_rate = damping * cosine * cosine * cosine if is_taut else 0.0
    return tension, by_strain, by_rate


@inner_kernel
def rank_one(a: float, b: float, x: float, y: float, z: float) -> Block:
    """Return the block a I + b w w' with w = (x, y, z)."""
    return a + b * x * x, b * x * y, b * x * z, a + b * y * y, b * y * z, a + b * z * z


@inner_kernel
def times(m: Block, x: float, y: float, z: float) -> Vector:
    """Return the block `m` times the vector (x, y, z)."""
    return m[0] * x + m[1] * y + m[2] * z, m[1] * x + m[3] * y + m[4] * z, m[2] * x + m[4] * y + m[5] * z


@inner_kernel
def adjugate(s: Block) -> tuple[Block, float]:
    """Return the adjugate of the block `s` and its determinant."""
    a = s[3] * s[5] - s[4] * s[4]
    b = s[2] * s[4] - s[1] * s[5]
    c = s[1] * s[4] - s[2] * s[3]
    adjugate = (a, b, c, s[0] * s[5] - s[2] * s[2], s[1] * s[2] - s[0] * s[4], s[0] * s[3] - s[1] * s[1])
    return adjugate, s[0] * a + s[1] * b + s[2] * c
