"""Read a bag: messages in order, columns, pandas frames. Streaming, without ROS, whatever state the bag is in.

>>> bag = Bag("runs/b2_calm_300")                           # doctest: +SKIP
>>> bag.frame("unit/odometry")["pose.pose.position.z"].std()  # doctest: +SKIP
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from mcap.records import Attachment, Channel, Metadata, Schema
from numpy.typing import NDArray

from heave_bags.cdr.canonical import Canonical
from heave_bags.cdr.columns import ColumnDecoder, Columns, join
from heave_bags.errors import BagError
from heave_bags.mcap.bounds import LARGEST_RECORD, LATEST_TIME
from heave_bags.mcap.files import (
    OUTCOME_RECORD,
    RUN_RECORD,
    BagSummary,
    FileSummary,
    TopicSummary,
    file_counts,
    information_in_record,
    is_first_file,
    read_information,
    sorted_files,
)
from heave_bags.mcap.loss import Loss
from heave_bags.mcap.recorded_loss import recorded_loss
from heave_bags.mcap.records import UNPARSEABLE, RecordFile, parse
from heave_bags.mcap.ros.qos import from_yaml
from heave_bags.mcap.scan import FileContents, McapScan, attachment_problem
from heave_bags.mcap.summary import read_summary

if TYPE_CHECKING:
    import pandas

LOG_TIME = "log_time"
TIME = "time"
_INDEX = re.compile(r"\[\d+\]")
_BATCH = 4096
_BATCH_BYTES = 4 << 20

Progress = Callable[[float], None]
"""Called with the share of the work that is done, 0 to 1."""


class RawMessage(NamedTuple):
    """One message of `topic` as recorded: `data`, serialised, with `log_time` and `publish_time` [ns]."""

    topic: str
    log_time: int
    publish_time: int
    data: bytes


@dataclass
class BagTopic(TopicSummary):
    """One topic of a bag, with the definition of its type, `schema`."""

    schema: str = ""


def no_progress(_share: float) -> None:
    """Report no progress."""


class Bag:
    """A bag to read: a rosbag2 folder or a single MCAP file.

    Attributes
    ----------
    path : the folder or file
    files, file_summaries : its MCAP files, in order, and what is in them (after the first look at `topics`)
    losses : what could not be read in the last pass, and what the recorder says it could not write; empty for a sound
        bag

    Raises BagError if there is no bag at `path`.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.files = _find_files(self.path)
        self.losses: list[Loss] = []
        folder = self.path if self.path.is_dir() else self.path.parent
        self._described = read_information(folder)
        self._stated_counts = file_counts(self._described)
        stated = recorded_loss(self._described)
        self._not_recorded = [] if stated is None else [stated.to_loss(self.path)]
        self._contents: list[FileContents] | None = None
        self.file_summaries: list[FileSummary] = []
        self._topics: dict[str, BagTopic] | None = None
        self._span: tuple[int, int] | None = None

    @cached_property
    def stated(self) -> Mapping[str, Any]:
        """What `metadata.yaml` says of the bag, or its last file where there is none; empty if neither does."""
        return self._described or information_in_record(self._surveyed()[-1].metadata)

    # What the bag is -----------------------------------------------------------------------------------------------

    @property
    def topics(self) -> Mapping[str, BagTopic]:
        """The topics by full name, sorted."""
        if self._topics is None:
            self._survey()
        assert self._topics is not None
        return self._topics

    @property
    def start_time(self) -> int:
        """Log time of the first message [ns]; 0 for an empty bag."""
        return self._spanned()[0]

    @property
    def end_time(self) -> int:
        """Log time of the last message [ns]; 0 for an empty bag."""
        return self._spanned()[1]

    @property
    def duration(self) -> float:
        """Time from the first message to the last [s]."""
        return (self.end_time - self.start_time) * 1e-9

    @property
    def message_count(self) -> int:
        """Number of messages."""
        return sum(topic.message_count for topic in self.topics.values())

    @property
    def run(self) -> dict[str, str]:
        """What the bag says of its run: scenario, seed, versions, git commit; empty for bags of others."""
        return self._record(RUN_RECORD)

    @property
    def outcome(self) -> dict[str, str]:
        """How the run went; empty if its recorder was killed, and for bags of others."""
        return self._record(OUTCOME_RECORD)

    @property
    def ros_distro(self) -> str:
        """The ROS distribution that the bag was recorded under; empty where it does not say."""
        return str(self.stated.get("ros_distro") or "")

    @property
    def metadata(self) -> list[tuple[str, dict[str, str]]]:
        """The metadata records of all files, as name and values, in order."""
        return [(record.name, record.metadata) for contents in self._surveyed() for record in contents.metadata]

    @property
    def attachments(self) -> dict[str, bytes]:
        """The files carried in the bag, by name."""
        return {name: attached.data for name, attached in self.attached.items()}

    @property
    def attached(self) -> dict[str, Attachment]:
        """The files carried in the bag, by name, with what the bag says of them."""
        return {file.name: file for contents in self._surveyed() for file in contents.attachments}

    def _record(self, name: str) -> dict[str, str]:
        merged: dict[str, str] = {}
        for found, values in self.metadata:
            if found == name:
                merged |= values
        return merged

    def resolve(self, topic: str) -> str:
        """Return the full name of a topic given by its full name or by the end of it, that in no namespace first.

        Raises BagError where it is not one.
        """
        if topic in self.topics:
            return topic
        root = "/" + topic.lstrip("/")
        if root in self.topics:  # what lies in no namespace goes before another run's beside it
            return root
        matches = [name for name in self.topics if name.endswith(root)]
        if len(matches) == 1:
            return matches[0]
        if matches:
            raise BagError(f"{self.path}: {topic} could be {' or '.join(matches)}")
        raise BagError(f"{self.path}: no topic {topic}; it has {', '.join(self.topics) or 'none'}")

    def has(self, topic: str) -> bool:
        """Return whether the bag has messages on a topic."""
        try:
            return self.topics[self.resolve(topic)].message_count > 0
        except BagError:
            return False

    def _surveyed(self) -> list[FileContents]:
        if self._contents is None:
            self._survey()
        assert self._contents is not None
        return self._contents

    def _spanned(self) -> tuple[int, int]:
        if self._span is None:
            self._survey()
        assert self._span is not None
        return self._span

    def _survey(self) -> None:
        """Learn topics, counts and times: from the summaries of the files, or by reading those that have none."""
        surveys = [_survey_file(path, self._stated_counts.get(path.name)) for path in self.files]
        self._contents = [survey.contents for survey in surveys]
        self.file_summaries = [survey.summary(path) for survey, path in zip(surveys, self.files, strict=True)]
        spans = [survey.span for survey in surveys if survey.span is not None]
        self._span = (min(span[0] for span in spans), max(span[1] for span in spans)) if spans else (0, 0)
        topics: dict[str, BagTopic] = {}
        for survey in surveys:
            for channel_id, channel in survey.contents.channels.items():
                known = topics.setdefault(channel.topic, _topic(channel, survey.contents.schemas))
                known.message_count += survey.counts.get(channel_id, 0)
        self._topics = dict(sorted(topics.items()))
        self.losses = [*(loss for contents in self._contents for loss in contents.losses), *self._not_recorded]

    # Messages ------------------------------------------------------------------------------------------------------

    def messages(
        self,
        topics: Collection[str] | None = None,
        *,
        start: int = 0,
        end: int = LATEST_TIME,
        progress: Progress = no_progress,
    ) -> Iterator[RawMessage]:
        """Yield messages in the order of the bag, file by file.

        Parameters
        ----------
        topics : names, full or their ends; all if None
        start, end : log times [ns]
        progress : called with the share of the bag that is read

        After the pass, `losses` holds what could not be read.
        """
        wanted = None if topics is None else {self.resolve(topic) for topic in topics}
        sizes = [path.stat().st_size for path in self.files]
        self.losses = []
        before = 0
        numbering: dict[str, int] | None = {} if is_first_file(self.files[0]) else None
        for path, size in zip(self.files, sizes, strict=True):
            scan = McapScan(
                path,
                start=start,
                end=end,
                wanted=None if wanted is None else _topic_filter(wanted),
                expected=self._stated_counts.get(path.name),
                numbering=numbering,
                progress=_shared_progress(progress, before, max(sum(sizes), 1)),
            )
            channels = scan.contents.channels
            for message in scan.messages():
                topic = channels[message.channel].topic
                yield RawMessage(topic, message.log_time, message.publish_time, message.data)
            self.losses += scan.contents.losses
            before += size
        self.losses += self._not_recorded
        progress(1.0)

    def decoded(self, topics: Collection[str] | None = None, **selection: Any) -> Iterator[tuple[RawMessage, Any]]:
        """Yield messages of `topics` with their content as objects, by mcap-ros2-support; `selection` as in `messages`.

        Messages that do not fit their definition are left out and counted in `losses`. Raises BagError for a topic
        whose definition is missing or cannot be.
        """
        decoders: dict[str, _MessageDecoder] = {}
        for message in self.messages(topics, **selection):
            decoder = decoders.get(message.topic)
            if decoder is None:
                decoder = decoders[message.topic] = _MessageDecoder(self._defined(message.topic))
            content = decoder.decode(message.data)
            if content is not None:
                yield message, content
        self._note_misfits({topic: decoder.misfits for topic, decoder in decoders.items()})

    def _defined(self, name: str) -> BagTopic:
        """Return a topic whose definition the bag holds; raises BagError for one without."""
        topic = self.topics[self.resolve(name)]
        if not topic.schema:
            raise BagError(f"{self.path}: {topic.name} ({topic.type}) was recorded without its definition")
        return topic

    def _note_misfits(self, misfits: Mapping[str, int]) -> None:
        self.losses += [
            Loss(self.path, None, f"messages of {topic} that do not fit their definition", messages=count)
            for topic, count in misfits.items()
            if count
        ]

    # Columns and frames --------------------------------------------------------------------------------------------

    def columns(
        self,
        selection: Mapping[str, Collection[str] | None],
        *,
        start: int = 0,
        end: int = LATEST_TIME,
        longest: int | None = None,
        most_bytes: int | None = None,
        progress: Progress = no_progress,
    ) -> dict[str, Columns]:
        """Return columns of several topics in one pass.

        Parameters
        ----------
        selection : per topic (full name or its end) the wanted fields, such as "pose.pose.position.z", or None for
            all. A name stands for everything below it; "status[].name" for that field of every element.
        start, end : log times [ns]
        longest : arrays and texts of more elements are left out; None takes all
        most_bytes : of messages that are taken; None sets no limit
        progress : called with the share of the bag that is read

        Returns
        -------
        Per topic as named in `selection`: columns of equal length; among them `log_time` [ns, int64] and `time` [s],
        the stamp of the message's header where it has one. Numeric arrays are columns of shape (n, elements).

        Messages that do not fit their definition are left out and counted in `losses`. Raises BagError for topics
        that are not there, definitions that are missing or cannot be, and more than `most_bytes`.
        """
        readers = {
            self.resolve(name): (name, _ColumnReader(self._defined(name), fields, longest))
            for name, fields in selection.items()
        }
        left = math.inf if most_bytes is None else most_bytes
        for message in self.messages(list(readers), start=start, end=end, progress=progress):
            left -= len(message.data)
            if left < 0:
                raise BagError(f"{self.path}: its messages exceed the limit of {most_bytes} bytes for an analysis")
            readers[message.topic][1].add(message)
        found = {name: reader.finish() for name, reader in readers.values()}
        self._note_misfits({topic: reader.misfits for topic, (_, reader) in readers.items()})
        return found

    @property
    def size(self) -> int:
        """Bytes of its files."""
        return sum(path.stat().st_size for path in self.files)

    def frame(
        self,
        topic: str,
        fields: Collection[str] | None = None,
        *,
        max_array: int = 16,
        start: int = 0,
        end: int = LATEST_TIME,
    ) -> pandas.DataFrame:
        """Return one `topic` as a pandas DataFrame with index `time` [s].

        Array fields become columns `name[0]`, `name[1]` ...; those of more than `max_array` elements (covariances,
        long cables) are left out unless named in `fields`. Log times from `start` to `end` [ns].
        """
        import pandas  # noqa: PLC0415 - half a second to import, for those who want frames only

        columns = self.columns({topic: fields}, start=start, end=end)[topic]
        time = columns.pop(TIME)
        flat: dict[str, NDArray[Any]] = {}
        for name, values in columns.items():
            if values.ndim == 1:
                flat[name] = values
            elif fields is not None or values.shape[1] <= max_array:
                flat |= {f"{name}[{index}]": values[:, index] for index in range(values.shape[1])}
        return pandas.DataFrame(flat, index=pandas.Index(time, name=TIME))


class _MessageDecoder:
    """Decodes messages of one topic as objects."""

    def __init__(self, topic: BagTopic) -> None:
        from mcap_ros2.decoder import DecoderFactory  # noqa: PLC0415 - only this way of reading needs it

        self._canonical = Canonical(topic.type, topic.schema)
        schema = Schema(id=1, name=topic.type, encoding="ros2msg", data=topic.schema.encode())
        try:
            self._decode = DecoderFactory().decoder_for("cdr", schema)
        except Exception as error:  # whatever a parser of others makes of a damaged definition
            raise BagError(f"{topic.name}: the definition of {topic.type} cannot be read: {error}") from error
        self.misfits = 0
        """Messages that did not fit their definition."""

    def decode(self, data: bytes) -> Any:
        """Return the message; None, and counted, if it does not fit the definition."""
        if self._decode is not None and self._canonical.fits(data):
            try:
                return self._decode(data)
            except (ValueError, LookupError, struct.error, ArithmeticError):
                pass
        self.misfits += 1
        return None


class _ColumnReader:
    """Collects the messages of one topic and decodes them in batches."""

    def __init__(self, topic: BagTopic, fields: Collection[str] | None, longest: int | None) -> None:
        self._decoder = ColumnDecoder(topic.type, topic.schema, _field_filter(fields), longest)
        self.misfits = 0
        """Messages that did not fit their definition."""
        self._messages: list[bytes] = []
        self._times: list[int] = []
        self._size = 0
        self._batches: list[tuple[int, Columns]] = []

    def add(self, message: RawMessage) -> None:
        self._messages.append(message.data)
        self._times.append(message.log_time)
        self._size += len(message.data)
        if len(self._messages) >= _BATCH or self._size >= _BATCH_BYTES:
            self._decode()

    def _decode(self) -> None:
        try:
            columns = self._decoder.decode(self._messages)
        except BagError:
            self._leave_out_misfits()
            if not self._messages:
                return
            columns = self._decoder.decode(self._messages)
        log_time = np.asarray(self._times, dtype=np.int64)
        time = _stamps(columns, log_time) * 1e-9 if self._decoder.has_header else log_time * 1e-9
        self._batches.append((log_time.size, {TIME: time, LOG_TIME: log_time, **columns}))
        self._messages, self._times, self._size = [], [], 0

    def _leave_out_misfits(self) -> None:
        fitting = [index for index, data in enumerate(self._messages) if self._decoder.fits(data)]
        self.misfits += len(self._messages) - len(fitting)
        self._messages = [self._messages[index] for index in fitting]
        self._times = [self._times[index] for index in fitting]

    def finish(self) -> Columns:
        if self._messages:
            self._decode()
        if not self._batches:
            return {TIME: np.empty(0), LOG_TIME: np.empty(0, dtype=np.int64)}
        return join(self._batches)


def _stamps(columns: Columns, log_time: NDArray[np.int64]) -> NDArray[np.int64]:
    """Take the stamps out of columns [ns]; where there is none, or none above 0, the log time stands for it."""
    seconds = columns.pop("header.stamp.sec", None)
    nanoseconds = columns.pop("header.stamp.nanosec", None)
    for part in (seconds, nanoseconds):
        if part is None or part.ndim != 1 or part.dtype.kind not in "iu":
            return log_time
    assert seconds is not None and nanoseconds is not None
    stamp = seconds.astype(np.int64) * 1_000_000_000 + nanoseconds.astype(np.int64)
    return np.where(stamp > 0, stamp, log_time)


def _field_filter(fields: Collection[str] | None) -> Callable[[str], bool] | None:
    if fields is None:
        return None
    wanted = tuple(fields)

    def is_wanted(path: str) -> bool:
        if path.startswith("header.stamp."):
            return True
        if _INDEX.sub("[]", path) in wanted:
            return True
        return any(path == name or path.startswith((name + ".", name + "[")) for name in wanted)

    return is_wanted


def _topic_filter(wanted: Collection[str]) -> Callable[[Channel], bool]:
    return lambda channel: channel.topic in wanted


def _shared_progress(progress: Progress, before: int, total: int) -> Callable[[int], None]:
    return lambda position: progress((before + position) / total)


def _topic(channel: Channel, schemas: Mapping[int, Schema]) -> BagTopic:
    schema = schemas.get(channel.schema_id)
    text = schema.data.decode("utf-8", "replace") if schema and schema.encoding == "ros2msg" else ""
    try:
        qos = from_yaml(channel.metadata.get("offered_qos_profiles", ""))
    except (TypeError, LookupError, ValueError, ArithmeticError, AttributeError):
        qos = ()
    return BagTopic(
        name=channel.topic,
        type=schema.name if schema else "",
        qos=qos,
        type_hash=channel.metadata.get("topic_type_hash", ""),
        schema=text,
    )


def _find_files(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise BagError(f"{path}: no such bag")
    files = sorted_files([found for found in path.glob("*.mcap") if found.is_file()])
    if not files:
        kind = "storage other than MCAP" if list(path.glob("*.db3")) else "no MCAP file"
        raise BagError(f"{path}: this folder holds {kind}; give the folder of a bag, or its .mcap file")
    return files


@dataclass
class _Survey:
    contents: FileContents
    counts: dict[int, int]
    span: tuple[int, int] | None

    def summary(self, path: Path) -> FileSummary:
        start, end = self.span or (0, 0)
        return FileSummary(path.name, start, end, sum(self.counts.values()))


def _survey_file(path: Path, expected: int | None) -> _Survey:
    """Learn what a file holds from its summary; read it through if it has none."""
    with RecordFile(path) as file:
        summary = read_summary(file)
        if summary is not None and summary.counts is not None and summary.channels:
            contents = FileContents(summary.schemas, summary.channels, complete=True)
            if _take_records(file, [*summary.metadata, *summary.attachments], contents):
                return _Survey(contents, summary.counts, summary.span)
    return _read_through(path, expected)


def _take_records(file: RecordFile, positions: Sequence[int], contents: FileContents) -> bool:
    """Take the attachments and metadata at these positions; tell whether all of them are there, whole."""
    for position in positions:
        record = file.record_at(position)
        if record is None or record.end > file.size or record.length > 2 * LARGEST_RECORD:
            return False
        body = file.body(record)
        try:
            content = parse(record.opcode, body)
        except UNPARSEABLE:
            return False
        if isinstance(content, Metadata):
            contents.metadata.append(content)
        elif isinstance(content, Attachment) and not attachment_problem(content, body, contents.attachments):
            contents.attachments.append(content)
        else:
            return False
    return True


def _read_through(path: Path, expected: int | None) -> _Survey:
    scan = McapScan(path, expected=expected, numbering={} if is_first_file(path) else None)
    first, last = math.inf, -math.inf
    for message in scan.messages():
        first, last = min(first, message.log_time), max(last, message.log_time)
    return _Survey(scan.contents, scan.counts, (int(first), int(last)) if scan.counts else None)


def summary_of(bag: Bag) -> BagSummary:
    """Return what a bag's `metadata.yaml` should say, from the files themselves."""
    topics: list[TopicSummary] = list(bag.topics.values())
    return BagSummary(bag.file_summaries, topics, bag.run, bag.ros_distro)
