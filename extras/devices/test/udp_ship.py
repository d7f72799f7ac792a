"""A ship's instruments on UDP: `python udp_ship.py MRU_PORT CELL_PORT`, until it is ended.

Every 0.05 s a sentence PNORSUB2 of a swell of 0.4 m and 8 s, as its maker documents it (heave positive down), and ten
times a second a line RD of a winch display, whose manual has its checksum (tension in kilonewtons). It knows nothing of
the suite. One sentence in 200 has a wrong checksum and 90 m of heave, one in 150 says that it is not valid, with 99 m.
"""

import functools
import math
import operator
import socket
import sys
import time

AMPLITUDE, PERIOD, INTERVAL = 0.4, 8.0, 0.05


def sentence(body: str) -> str:
    return f"${body}*{functools.reduce(operator.xor, body.encode(), 0):02X}"


def motion(number: int, elapsed: float) -> str:
    omega = 2.0 * math.pi / PERIOD
    up, rate = AMPLITUDE * math.sin(omega * elapsed), AMPLITUDE * omega * math.cos(omega * elapsed)
    milliseconds = round(1e3 * elapsed) + 1_000_000
    if number % 200 == 199:
        return f"$PNORSUB2,{milliseconds},2,+0.117,-0.505,259.893,90.0,0.0,1*00"
    if number % 150 == 120:
        return sentence(f"PNORSUB2,{milliseconds},2,+0.117,-0.505,259.893,99.0,0.0,0")
    return sentence(f"PNORSUB2,{milliseconds},2,+0.117,-0.505,259.893,{-up:.4f},{-rate:.4f},1")


def tension(elapsed: float) -> str:
    covered = f"RD,{25.0 + math.sin(elapsed):08.3f},-001.250,0345.600,"
    return f"{covered}{sum(covered.encode()):04d}"


def main() -> None:
    mru, cell = (("127.0.0.1", int(port)) for port in sys.argv[1:3])
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    began = time.monotonic()
    number = 0
    while True:
        elapsed = time.monotonic() - began
        line.sendto(f"{motion(number, elapsed)}\r\n".encode(), mru)
        if number % 2 == 0:
            line.sendto(f"{tension(elapsed)}\r\n".encode(), cell)
        number += 1
        time.sleep(max(0.0, began + number * INTERVAL - time.monotonic()))


if __name__ == "__main__":
    main()
