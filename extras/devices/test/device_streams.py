"""What every decoder must keep: the same samples whatever the pieces, and nothing raised by random bytes."""

import itertools

from hypothesis import strategies as st


def in_pieces(decoder, data, cuts):
    """Return the samples of `data` fed in pieces that are cut at `cuts`."""
    places = [0, *sorted(cut % (len(data) + 1) for cut in cuts), len(data)]
    samples = [sample for a, b in itertools.pairwise(places) for sample in decoder.feed(data[a:b])]
    return samples + decoder.end()


CUTS = st.lists(st.integers(0, 10_000), max_size=12)
