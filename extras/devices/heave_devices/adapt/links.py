"""The way to a device: a serial port, UDP or TCP, read by a thread of its own that opens it again where it breaks."""

from __future__ import annotations

import os
import socket
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable

import serial
from heave_bringup.errors import CommandError

from heave_devices.maps.link import Link

REOPEN_PERIOD = 1.0
"""Wall time between two attempts to open a link [s]."""
_WAIT = 0.2
"""Longest wait for bytes, after which the end is looked for [s]."""
_LARGEST = 65_536
_UNFORESEEN = "What came was not used; the link is opened again"
_GONE = "the port is gone: its cable was pulled, or another program reads it. It is opened again"


class LinkThread(ABC):
    """Opens a `link`, serves it until it breaks, and opens it again; nothing ends it in silence.

    Attributes
    ----------
    opened : times that the link was opened
    failures : times that what came could not be processed, or the link failed in a way that nobody foresaw
    failed : the last of them, in words
    """

    def __init__(self, link: Link) -> None:
        self.link = link
        self.opened = self.failures = 0
        self.failed = ""
        self._problems = {"read": "not connected yet", "write": ""}
        self._is_ended = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name=f"link {link}", daemon=True)

    @property
    def problem(self) -> str:
        """Why nothing can be read or written now, in words; "" while all is well."""
        return self._problems["read"] or self._problems["write"]

    def start(self) -> None:
        """Begin to read."""
        self._thread.start()

    def close(self) -> None:
        """End it."""
        with self._changed:
            self._is_ended = True
            self._changed.notify()
        if self._thread.is_alive():
            self._thread.join(3.0)

    def _run(self) -> None:
        while not self._is_ended:
            try:
                self._serve()
            except OSError as error:  # pyserial's own are of its kind
                self._problems = {"read": words_of(error), "write": ""}
            except Exception as error:
                self.failures += 1
                self.failed = f"{type(error).__name__}: {words_of(error)}. {_UNFORESEEN}"
                self._problems = {"read": self.failed, "write": ""}
            self._leave()
            with self._changed:
                self._changed.wait_for(lambda: self._is_ended, REOPEN_PERIOD)

    @abstractmethod
    def _serve(self) -> None:
        """Open the link and serve it to the end; raise OSError where it breaks."""

    @abstractmethod
    def _leave(self) -> None:
        """Close what is open."""


class LinkReader(LinkThread):
    """Reads the bytes of one link, and sends on it.

    Parameters
    ----------
    link : what is opened
    on_bytes : called, in the thread of this reader, with the bytes and whether they are a whole datagram; None: what
        comes is not used, and over UDP the link says where to, not where from

    Attributes
    ----------
    strangers : datagrams of another sender than the one that the map names, or that spoke first

    Raises CommandError where a serial port or a UDP port cannot be opened at the start; TCP is tried again.
    """

    def __init__(self, link: Link, on_bytes: Callable[[bytes, bool], None] | None) -> None:
        super().__init__(link)
        self.strangers = 0
        self._on_bytes = on_bytes or (lambda _data, _is_whole: None)
        self._port: serial.Serial | socket.socket | None = None
        self._to = (link.place, link.number) if on_bytes is None else None
        self._peer: tuple[str, int] | None = self._to
        if link.kind != "tcp":
            try:
                self._port = self._open()
            except (OSError, ValueError) as error:
                raise CommandError(f"{link}: cannot be opened: {words_of(error)}") from None

    def send(self, data: bytes) -> None:
        """Send `data` to the device; over UDP to whom spoke last. What cannot be sent is the link's problem."""
        try:
            if isinstance(self._port, serial.Serial):
                self._port.write(data)
            elif self._port is not None and self.link.kind == "tcp":
                self._port.sendall(data)
            elif self._port is not None and self._peer is not None:
                self._port.sendto(data, self._to or self._peer)
            self._problems["write"] = ""
        except (OSError, serial.SerialException) as error:
            self._problems["write"] = f"cannot send: {words_of(error)}"

    def close(self) -> None:
        """End reading."""
        super().close()
        self._leave()

    def _serve(self) -> None:
        if self._port is None:
            self._port = self._open()
        while not self._is_ended:
            self._read(self._port)

    def _leave(self) -> None:
        port, self._port = self._port, None
        if port is not None:
            port.close()

    def _open(self) -> serial.Serial | socket.socket:
        link = self.link
        port: serial.Serial | socket.socket
        if link.kind == "serial":
            port = serial.Serial(link.place, link.number, timeout=_WAIT, write_timeout=_WAIT)
        elif link.kind == "udp":
            port = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            try:
                if self._to is None:
                    port.bind((link.place, link.number))
            except OSError:
                port.close()
                raise
            port.settimeout(_WAIT)
        else:
            port = socket.create_connection((link.place, link.number), timeout=2.0)
            port.settimeout(_WAIT)
        self.opened += 1
        self._problems = {"read": "", "write": ""}
        return port

    def _read(self, port: serial.Serial | socket.socket) -> None:
        """Read once; raise OSError where the link has ended."""
        if isinstance(port, serial.Serial):
            try:
                data = port.read(max(1, min(port.in_waiting, _LARGEST)))
            except TypeError:  # pyserial of a port that went away
                raise ConnectionError(_GONE) from None
            if data:
                self._on_bytes(data, False)
            return
        try:
            if self.link.kind == "udp":
                data, peer = port.recvfrom(_LARGEST)
                if self._is_of_device(peer):
                    self._on_bytes(data, True)
                return
            data = port.recv(_LARGEST)
        except TimeoutError:
            return
        if not data:
            raise ConnectionError("the other side has closed the connection")
        self._on_bytes(data, False)

    def _is_of_device(self, peer: tuple[str, int]) -> bool:
        """Return whether a datagram's sender, host and port, is the device; it is who is answered."""
        first = self._peer or peer
        self.strangers += (self.link.sender or first[0]) != peer[0]
        if self.link.sender and self.link.sender != peer[0]:
            return False
        self._peer = peer
        return True


def words_of(error: BaseException) -> str:
    """Return in one line what an `error` says, or its kind where it says nothing."""
    number = getattr(error, "errno", None)  # pyserial puts the name of the port into the text once more
    if isinstance(number, int):
        return os.strerror(number)
    if "returned no data" in str(error):
        return _GONE
    return " ".join(str(error).split()) or type(error).__name__
