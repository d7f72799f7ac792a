"""Damage by chance: what happens to files on disks and lines, and how much of a bag it truly costs."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from heave_bags.mcap.loss import Loss
from heave_bags.mcap.reader import Bag, RawMessage

KINDS = ("flip", "noise", "cut", "insertion", "deletion", "repetition", "zeros", "chunk")


def chunk_positions(data: bytes) -> list[int]:
    """Return where the chunks of a file are, whose compression is zstd."""
    found, position = [], data.find(b"\x04\x00\x00\x00zstd")
    while position >= 0:
        if data[position - 37] == 6:
            found.append(position - 37)
        position = data.find(b"\x04\x00\x00\x00zstd", position + 1)
    return found


def damaged(data: bytes, kind: str, chance: random.Random) -> bytes:
    """Return a file with damage of a kind; the magic at its beginning stays."""
    broken, size = bytearray(data), len(data)
    at = chance.randrange(8, size - 1)
    if kind == "flip":
        broken[at] ^= 1 << chance.randrange(8)
    elif kind == "noise":
        for _ in range(20):
            broken[chance.randrange(8, size)] = chance.randrange(256)
    elif kind == "cut":
        del broken[at:]
    elif kind == "insertion":
        broken[at:at] = chance.randbytes(chance.randrange(1, 200))
    elif kind == "deletion":
        del broken[at : at + chance.randrange(1, 2000)]
    elif kind == "repetition":
        start = chance.randrange(8, size)
        broken[at:at] = broken[start : start + chance.randrange(1, 20_000)]
    elif kind == "zeros":
        length = min(chance.randrange(1, 3000), size - at)
        broken[at : at + length] = bytes(length)
    else:
        for chunk in chance.sample(chunk_positions(data) or [at], 1):
            broken[chunk + 60] ^= 0x5A
    return bytes(broken)


def damage_one_file(folder: Path, kind: str, chance: random.Random) -> Path:
    """Damage a file of a bag by chance, in place; return the file."""
    path = chance.choice(sorted(folder.glob("*.mcap")))
    path.write_bytes(damaged(path.read_bytes(), kind, chance))
    return path


def true_loss(before: Sequence[RawMessage], after: Sequence[RawMessage]) -> int:
    """Return how many messages are missing; raises AssertionError if there are some that were never written."""
    sound, found = Counter(before), Counter(after)
    assert not found - sound, "messages that nobody wrote"
    return (sound - found).total()


def stated_loss(losses: Sequence[Loss]) -> int | None:
    """Return how many messages are said to be lost; None if it is said of some that their number is not known."""
    counts = [loss.messages for loss in losses]
    return None if None in counts else sum(count or 0 for count in counts)


def read_all(folder: Path) -> tuple[list[RawMessage], list[Loss]]:
    """Return the messages of a bag and what is said to be lost."""
    bag = Bag(folder)
    found = list(bag.messages())
    return found, bag.losses
