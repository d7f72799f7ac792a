"""What a call allocates in C: the tick of the core is to allocate nothing."""

import ctypes
from collections.abc import Callable

NAMES = ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost")
"""Fields of mallinfo2 of glibc."""

CALLS, BLOCK = 2000, 32
"""Calls in a row, and the least block of malloc [bytes]."""


class Info(ctypes.Structure):
    """What mallinfo2 returns."""

    _fields_ = [(name, ctypes.c_size_t) for name in NAMES]


def allocated() -> int:
    """Return the bytes that C has allocated in this process."""
    ask = ctypes.CDLL(None).mallinfo2
    ask.restype = Info
    info = ask()
    return int(info.uordblks + info.hblkhd)


def allocates(call: Callable[[], object]) -> bool:
    """Tell whether each `call` takes memory that it keeps; Python itself may take a block meanwhile."""

    def grown() -> int:
        before = allocated()
        for _ in range(CALLS):
            call()
        return allocated() - before

    return min(grown() for _ in range(5)) >= CALLS * BLOCK / 2
