"""The line's kernels by themselves: vector instructions, elimination, reductions along a tile."""

import platform
import re

import numpy as np
import pytest
from cable_sim_node.line import layout as at
from cable_sim_node.line.assembly import assemble_segments
from cable_sim_node.line.elimination import solve_blocks
from cable_sim_node.line.tiles import largest_of, sum_of
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit


@njit(error_model="numpy")
def assemble(tile, count):
    assemble_segments(tile, count, 1.0, 1.0)


@njit(error_model="numpy")
def solve(tiles, count):
    return solve_blocks(tiles, count)


@njit(error_model="numpy")
def reduce(tile, count):
    largest = largest_of(tile.copy(), count)
    return largest, sum_of(tile, count)


@pytest.mark.skipif(platform.machine() not in {"x86_64", "AMD64"}, reason="the instructions' names are those of x86")
def test_the_loop_over_segments_is_made_of_vector_instructions():
    """One statement that does not vectorise costs a factor of five, and shows in nothing else: three square roots."""
    assemble(np.ones(at.TILE_COLUMNS * at.STRIDE), 1)
    (assembly,) = assemble.inspect_asm().values()
    assert len(re.findall(r"\bv?sqrtpd\b", assembly)) >= 3


@settings(max_examples=30, deadline=None)
@given(count=st.integers(1, 140), seed=st.integers(0, 1000))
def test_elimination_from_both_ends_solves_the_system(count, seed):
    """Against the dense solution by LAPACK; the product -r c is that of the answer."""
    random = np.random.default_rng(seed)
    tiles = np.zeros((count // at.TILE + 1, at.TILE_COLUMNS * at.STRIDE))
    dense, right = np.zeros((3 * count, 3 * count)), random.normal(size=3 * count)
    upper = np.triu_indices(3)
    for i in range(count):
        tile, j = tiles[i >> at.SHIFT], i & at.LANES
        node, above = slice(3 * i, 3 * i + 3), slice(3 * i + 3, 3 * i + 6)
        half = random.normal(size=(3, 3))
        dense[node, node] = half @ half.T + 12.0 * np.eye(3)
        coupling = random.normal(size=(3, 3))
        coupling += coupling.T
        if i + 1 < count:
            dense[node, above] = dense[above, node] = coupling
        tile[at.DXX + j : at.UXX + j : at.STRIDE] = dense[node, node][upper]
        tile[at.UXX + j : at.RX + j : at.STRIDE] = coupling[upper]
        tile[at.RX + j : at.CX + j : at.STRIDE] = right[node]
    decrease = solve(tiles, count)
    answer = [tiles[i >> at.SHIFT, at.CX + (i & at.LANES) : at.END_XX : at.STRIDE][:3] for i in range(count)]
    expected = np.linalg.solve(dense, -right)
    assert np.concatenate(answer) == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())
    assert decrease == pytest.approx(-right @ expected, rel=1e-9, abs=1e-9)


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=at.TILE))
def test_largest_and_sum_of_a_column_are_those_of_its_numbers_in_use(numbers):
    tile = np.full(at.TILE_COLUMNS * at.STRIDE, 1e9)
    tile[at.SCRATCH : at.SCRATCH + len(numbers)] = numbers
    largest, total = reduce(tile, len(numbers))
    assert largest == max(numbers)
    assert total == pytest.approx(np.sum(numbers), rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("place", [0, 1, 30, 63])
def test_the_largest_of_a_column_with_a_number_that_is_none_is_none(place):
    tile = np.zeros(at.TILE_COLUMNS * at.STRIDE)
    tile[at.SCRATCH + place] = np.nan
    assert np.isnan(reduce(tile, at.TILE)[0])
