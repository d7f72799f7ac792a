"""Where a recorder's bytes go: the MCAP file, and beside it a journal that holds the open chunk, so that a crash
loses nothing acknowledged.

`DirectStorage` writes at once, and a slow disk holds up its caller: right in lockstep, where the run waits.
`BackgroundStorage` writes in a thread: right in real time, where nothing may wait; what it has not yet written is
bounded, and what does not fit is refused and reported.
"""

from __future__ import annotations

import errno
import os
import struct
import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from heave_bags.errors import StorageError
from heave_bags.mcap.bounds import LARGEST_RECORD
from heave_bags.mcap.files import replace_metadata
from heave_bags.mcap.summary import interim_ending

JOURNAL_SUFFIX = ".journal"
_JOURNAL_HEAD = struct.Struct("<8sQ")
_JOURNAL_MAGIC = b"HVJRNL01"

BACKLOG_LIMIT = 256 << 20
"""Bytes that may wait for a slow disk: twenty seconds of ten thousand messages of 1 kB a second."""


class Storage(Protocol):
    """What a bag file is written to."""

    def write(self, data: bytes, /) -> object:
        """Append `data` to the file, which ends properly after each piece, so that every reader opens it at any time.

        Raises StorageError if the write fails; the file then ends with the last whole piece.
        """
        ...

    def finish(self, data: bytes, /) -> object:
        """Append `data`, the piece that holds the file's own ending. Raises StorageError as `write` does."""
        ...

    def describe(self, text: bytes) -> object:
        """Make `text` the `metadata.yaml` beside the file. Raises StorageError if the write fails."""
        ...

    def acknowledge(self, pending: bytes) -> None:
        """Append to the journal what the open chunk has gained, `pending`.

        When it returns, a crash of this process does not lose it.
        """
        ...

    def close(self) -> None:
        """Close the file and remove the journal."""
        ...


def journal_path(path: Path) -> Path:
    """Return the journal of the MCAP file `path`."""
    return path.with_name(path.name + JOURNAL_SUFFIX)


@dataclass(frozen=True)
class Journal:
    """What was acknowledged after byte `position` of a file: records, which may end in the middle of one."""

    position: int
    records: bytes


def read_journal(path: Path) -> Journal | None:
    """Return the journal of `path`; None if there is none."""
    try:
        with journal_path(path).open("rb") as stream:
            data = stream.read(LARGEST_RECORD)
    except OSError:
        return None
    if len(data) < _JOURNAL_HEAD.size:
        return None
    magic, position = _JOURNAL_HEAD.unpack_from(data)
    return Journal(position, data[_JOURNAL_HEAD.size :]) if magic == _JOURNAL_MAGIC else None


def _write_all(descriptor: int, data: bytes, position: int | None = None) -> None:
    """Write at a position of a file, or at its current one."""
    view = memoryview(data)
    while view:
        if position is None:
            written = os.write(descriptor, view)
        else:
            written = os.pwrite(descriptor, view, position)
            position += written
        view = view[written:]


class DirectStorage:
    """Writes to the file `path` and its journal at once, without buffers of its own.

    Raises StorageError if the files cannot be made.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._size = 0
        self._ending = interim_ending()
        try:
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644)
            self._journal = os.open(journal_path(path), os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
        except OSError as error:
            raise StorageError(f"{path}: cannot be created: {error.strerror}") from error

    def write(self, data: bytes, /) -> None:
        """See Storage: all or nothing; the journal starts again."""
        self._append(data, self._ending)
        self._restart_journal()

    def finish(self, data: bytes, /) -> None:
        """See Storage: all or nothing."""
        self._append(data, b"")

    def _append(self, data: bytes, ending: bytes) -> None:
        """Write in place of the interim ending, followed by a new one."""
        try:
            _write_all(self._file, data + ending, self._size)
        except OSError as error:
            self._undo()
            raise StorageError(_refusal(self.path, error)) from error
        self._size += len(data)

    def _undo(self) -> None:
        """Cut off a piece that was written in part; what ended the file before it ends it again."""
        ending = self._ending if self._size else b""
        with suppress(OSError):  # a disk so full that it does not even accept again what it had
            _write_all(self._file, ending, self._size)
            os.ftruncate(self._file, self._size + len(ending))
            return
        os.ftruncate(self._file, self._size)

    def describe(self, text: bytes) -> None:
        """See Storage: in one step."""
        try:
            replace_metadata(self.path.parent, text)
        except OSError as error:
            raise StorageError(_refusal(self.path.parent, error)) from error

    def _restart_journal(self) -> None:
        try:
            os.ftruncate(self._journal, 0)
            os.lseek(self._journal, 0, os.SEEK_SET)
            _write_all(self._journal, _JOURNAL_HEAD.pack(_JOURNAL_MAGIC, self._size))
        except OSError as error:
            raise StorageError(_refusal(journal_path(self.path), error)) from error

    def acknowledge(self, pending: bytes) -> None:
        """See Storage."""
        if not pending:
            return
        try:
            _write_all(self._journal, pending)
        except OSError as error:
            raise StorageError(_refusal(journal_path(self.path), error)) from error

    def close(self) -> None:
        """Close the file and remove the journal."""
        os.close(self._file)
        os.close(self._journal)
        journal_path(self.path).unlink(missing_ok=True)


def _refusal(path: Path, error: OSError) -> str:
    full = error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
    return f"{path}: " + ("the disk is full" if full else f"cannot be written: {error.strerror}")


class BackgroundStorage:
    """Passes everything to another storage in a thread, in order.

    `write` and `acknowledge` return at once. What goes wrong in the thread is raised by the next call. Raises
    StorageError where more than `limit` bytes wait.
    """

    def __init__(self, storage: Storage, limit: int = BACKLOG_LIMIT) -> None:
        self._storage = storage
        self._limit = limit
        self._queue: deque[tuple[Callable[[bytes], object], bytes]] = deque()
        self._waiting = threading.Condition()
        self._closing = False
        self._error: StorageError | None = None
        self.backlog = 0
        self._thread = threading.Thread(target=self._work, name="bag writer", daemon=True)
        self._thread.start()

    def write(self, data: bytes, /) -> None:
        """See Storage: later."""
        self._put(self._storage.write, data)

    def finish(self, data: bytes, /) -> None:
        """See Storage: later."""
        self._put(self._storage.finish, data)

    def describe(self, text: bytes) -> None:
        """See Storage: later."""
        self._put(self._storage.describe, text)

    def acknowledge(self, pending: bytes) -> None:
        """See Storage: later; a slow disk delays the acknowledgement, not the caller."""
        if pending:
            self._put(self._storage.acknowledge, pending)

    def _put(self, work: Callable[[bytes], object], data: bytes) -> None:
        with self._waiting:
            if self._error is not None:
                raise self._error
            if self.backlog + len(data) > self._limit:
                raise StorageError(f"the disk is too slow: {self.backlog / 1e6:.1f} MB are waiting to be written")
            self._queue.append((work, data))
            self.backlog += len(data)
            self._waiting.notify()

    def _work(self) -> None:
        while True:
            with self._waiting:
                self._waiting.wait_for(lambda: self._queue or self._closing)
                if not self._queue:
                    return
                work, data = self._queue.popleft()
            try:
                work(data)
            except StorageError as error:
                with self._waiting:
                    self._error = error
                    self._queue.clear()
                    self.backlog = 0
                return
            with self._waiting:
                self.backlog -= len(data)

    def close(self) -> None:
        """Write what waits, then close. Raises StorageError if something could not be written."""
        with self._waiting:
            self._closing = True
            self._waiting.notify()
        self._thread.join()
        self._storage.close()
        if self._error is not None:
            raise self._error


def open_in_background(path: Path) -> Storage:
    """Return what writes the file at `path` in a thread."""
    return BackgroundStorage(DirectStorage(path))
