"""How much memory a process has used."""

from pathlib import Path


def peak_memory() -> int:
    """Return the most memory that this program has held [bytes].

    Linux counts it for the program alone. The resident size of getrusage would hold that of the process it was forked
    from as well.
    """
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return next(1024 * int(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM:"))
