"""Read a bag: messages in order, columns, pandas frames. Streaming, without ROS, whatever state the bag is in.

>>> bag = Bag("runs/b2_calm_300")                           # doctest: +SKIP
>>> bag.frame("unit/odometry")["pose.pose.position.z"].std()  # doctest: +SKIP
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import yaml
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Schema
from numpy.typing import NDArray

from heave_bags.cdr.columns import ColumnDecoder, Columns, join
from heave_bags.errors import BagError
from heave_bags.mcap.files import (
    METADATA_NAME,
    OUTCOME_RECORD,
    RUN_RECORD,
    BagSummary,
    FileSummary,
    TopicSummary,
    sorted_files,
)
from heave_bags.mcap.qos import from_yaml
from heave_bags.mcap.scan import FileContents, Loss, McapScan

if TYPE_CHECKING:
    import pandas

LOG_TIME = "log_time"
TIME = "time"
_BATCH = 4096
_BATCH_BYTES = 4 << 20

Progress = Callable[[float], None]
"""Called with the share of the work that is done, 0 to 1."""


class RawMessage(NamedTuple):
    """One message as recorded; times in nanoseconds."""

    topic: str
    log_time: int
    publish_time: int
    data: bytes


@dataclass
class BagTopic(TopicSummary):
    """One topic of a bag, with the definition of its type."""

    schema: str = ""


def no_progress(_share: float) -> None:
    """Report no progress."""


class Bag:
    """A bag to read: a rosbag2 folder or a single MCAP file.

    Attributes
    ----------
    path : the folder or file
    files, file_summaries : its MCAP files, in order, and what is in them (after the first look at `topics`)
    losses : what could not be read in the last pass; empty for a sound bag

    Raises BagError if there is no bag at `path`.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.files = _find_files(self.path)
        self.losses: list[Loss] = []
        self._contents: list[FileContents] | None = None
        self.file_summaries: list[FileSummary] = []
        self._topics: dict[str, BagTopic] | None = None
        self._span: tuple[int, int] | None = None

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
    def attachments(self) -> dict[str, bytes]:
        """The files carried in the bag, by name."""
        return {file.name: file.data for contents in self._surveyed() for file in contents.attachments}

    def _record(self, name: str) -> dict[str, str]:
        merged: dict[str, str] = {}
        for contents in self._surveyed():
            for record in contents.metadata:
                if record.name == name:
                    merged |= record.metadata
        return merged

    def resolve(self, topic: str) -> str:
        """Return the full name of a topic given by its full name or by the end of it.

        Raises BagError where it is not one.
        """
        if topic in self.topics:
            return topic
        matches = [name for name in self.topics if name.endswith("/" + topic.lstrip("/"))]
        if len(matches) == 1:
            return matches[0]
        if matches:
            raise BagError(f"{self.path}: {topic} could be {' or '.join(matches)}")
        raise BagError(f"{self.path}: there is no topic {topic}; it has {', '.join(self.topics) or 'none'}")

    def has(self, topic: str) -> bool:
        """Tell whether the bag has messages on a topic."""
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
        surveys = [_survey_file(path) for path in self.files]
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
        self.losses = [loss for contents in self._contents for loss in contents.losses]

    # Messages ------------------------------------------------------------------------------------------------------

    def messages(
        self,
        topics: Collection[str] | None = None,
        *,
        start: int = 0,
        end: int = 1 << 63,
        progress: Progress = no_progress,
    ) -> Iterator[RawMessage]:
        """Yield messages in the order of the bag, one file behind the other.

        Parameters
        ----------
        topics : names, full or their ends; all if None
        start, end : log times [ns]

        After the pass, `losses` holds what could not be read.
        """
        wanted = None if topics is None else {self.resolve(topic) for topic in topics}
        sizes = [path.stat().st_size for path in self.files]
        self.losses = []
        before = 0
        for path, size in zip(self.files, sizes, strict=True):
            scan = McapScan(
                path,
                start=start,
                end=end,
                wanted=None if wanted is None else _topic_filter(wanted),
                progress=_shared_progress(progress, before, max(sum(sizes), 1)),
            )
            names: dict[int, str] = {}
            for message in scan.messages():
                name = names.get(message.channel)
                if name is None:
                    if message.channel not in scan.contents.channels:
                        continue
                    name = names[message.channel] = scan.contents.channels[message.channel].topic
                yield RawMessage(name, message.log_time, message.publish_time, message.data)
            self.losses += scan.contents.losses
            before += size
        progress(1.0)

    def decoded(self, topics: Collection[str] | None = None, **selection: Any) -> Iterator[tuple[RawMessage, Any]]:
        """Yield messages with their content as objects (by mcap-ros2-support); `selection` as in `messages`."""
        from mcap_ros2.decoder import DecoderFactory  # noqa: PLC0415 - only this way of reading needs it

        factory = DecoderFactory()
        decoders: dict[str, Callable[[bytes], Any] | None] = {}
        for number, message in enumerate(self.messages(topics, **selection)):
            if message.topic not in decoders:
                topic = self.topics[message.topic]
                schema = Schema(id=number + 1, name=topic.type, encoding="ros2msg", data=topic.schema.encode())
                decoders[message.topic] = factory.decoder_for("cdr", schema)
            decoder = decoders[message.topic]
            if decoder is None:
                raise BagError(f"{self.path}: {message.topic} cannot be decoded")
            yield message, decoder(message.data)

    # Columns and frames --------------------------------------------------------------------------------------------

    def columns(
        self,
        selection: Mapping[str, Collection[str] | None],
        *,
        start: int = 0,
        end: int = 1 << 63,
        progress: Progress = no_progress,
    ) -> dict[str, Columns]:
        """Return columns of several topics in one pass.

        Parameters
        ----------
        selection : per topic (full name or its end) the wanted fields, such as "pose.pose.position.z", or None for
        all; a name stands for
            everything below it
        start, end : log times [ns]

        Returns
        -------
        Per topic as named in `selection`: columns of equal length; among them `log_time` [ns, int64] and `time` [s],
        the stamp of the message's header where it has one. Numeric arrays are columns of shape (n, elements).
        """
        readers = {self.resolve(name): (name, self._reader(name, fields)) for name, fields in selection.items()}
        for message in self.messages(list(readers), start=start, end=end, progress=progress):
            readers[message.topic][1].add(message)
        return {name: reader.finish() for name, reader in readers.values()}

    def _reader(self, name: str, fields: Collection[str] | None) -> _ColumnReader:
        topic = self.topics[self.resolve(name)]
        if not topic.schema:
            raise BagError(f"{self.path}: {topic.name} ({topic.type}) was recorded without its definition")
        return _ColumnReader(topic, fields)

    def frame(
        self,
        topic: str,
        fields: Collection[str] | None = None,
        *,
        max_array: int = 16,
        start: int = 0,
        end: int = 1 << 63,
    ) -> pandas.DataFrame:
        """Return one topic as a pandas DataFrame with index `time` [s].

        Array fields become columns `name[0]`, `name[1]` ...; those of more than `max_array` elements (covariances,
        long cables) are left out unless named in `fields`.
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


class _ColumnReader:
    """Collects the messages of one topic and decodes them in batches."""

    def __init__(self, topic: BagTopic, fields: Collection[str] | None) -> None:
        self._decoder = ColumnDecoder(topic.type, topic.schema, _field_filter(fields))
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
        columns = self._decoder.decode(self._messages)
        log_time = np.asarray(self._times, dtype=np.int64)
        seconds = columns.pop("header.stamp.sec", None)
        nanoseconds = columns.pop("header.stamp.nanosec", None)
        time = log_time * 1e-9
        if self._decoder.has_header and seconds is not None and nanoseconds is not None:
            stamp = seconds.astype(np.int64) * 1_000_000_000 + nanoseconds
            time = np.where(stamp > 0, stamp, log_time) * 1e-9
        self._batches.append((log_time.size, {TIME: time, LOG_TIME: log_time, **columns}))
        self._messages, self._times, self._size = [], [], 0

    def finish(self) -> Columns:
        if self._messages:
            self._decode()
        if not self._batches:
            return {TIME: np.empty(0), LOG_TIME: np.empty(0, dtype=np.int64)}
        return join(self._batches)


def _field_filter(fields: Collection[str] | None) -> Callable[[str], bool] | None:
    if fields is None:
        return None
    wanted = tuple(fields)

    def is_wanted(path: str) -> bool:
        if path.startswith("header.stamp."):
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
    except (yaml.YAMLError, TypeError, KeyError, ValueError, AttributeError):
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
        raise BagError(f"{path}: there is no such bag")
    files = sorted_files(list(path.glob("*.mcap")))
    if not files:
        kind = "another storage than MCAP" if list(path.glob("*.db3")) else "no MCAP file"
        raise BagError(f"{path}: this folder holds {kind}")
    return files


@dataclass
class _Survey:
    contents: FileContents
    counts: dict[int, int]
    span: tuple[int, int] | None

    def summary(self, path: Path) -> FileSummary:
        start, end = self.span or (0, 0)
        return FileSummary(path.name, start, end, sum(self.counts.values()))


def _survey_file(path: Path) -> _Survey:
    """Learn what a file holds from its summary; read it through if it has none."""
    try:
        with path.open("rb") as stream:
            reader = make_reader(stream)
            summary = reader.get_summary()
            if summary and summary.statistics and summary.channels:
                contents = FileContents(dict(summary.schemas), dict(summary.channels), complete=True)
                contents.metadata = list(reader.iter_metadata())
                contents.attachments = list(reader.iter_attachments())
                statistics = summary.statistics
                span = (statistics.message_start_time, statistics.message_end_time)
                return _Survey(
                    contents, dict(statistics.channel_message_counts), span if statistics.message_count else None
                )
    except OSError as error:
        raise BagError(f"{path}: cannot be read: {error.strerror}") from error
    except (McapError, struct.error, ValueError, LookupError):
        return _read_through(path)
    return _read_through(path)


def _read_through(path: Path) -> _Survey:
    scan = McapScan(path)
    counts: dict[int, int] = {}
    first, last = math.inf, -math.inf
    for message in scan.messages():
        counts[message.channel] = counts.get(message.channel, 0) + 1
        first, last = min(first, message.log_time), max(last, message.log_time)
    return _Survey(scan.contents, counts, (int(first), int(last)) if counts else None)


def summary_of(bag: Bag) -> BagSummary:
    """Return what a bag's `metadata.yaml` should say, from the files themselves."""
    topics: list[TopicSummary] = list(bag.topics.values())
    distro = str(metadata_of(bag).get("ros_distro", ""))
    return BagSummary(bag.file_summaries, topics, bag.run, distro)


def metadata_of(bag: Bag) -> dict[str, Any]:
    """Return the content of a bag's `metadata.yaml`; empty if it has none or it cannot be read."""
    path = bag.path / METADATA_NAME
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError, UnicodeDecodeError):
        return {}
    information = content.get("rosbag2_bagfile_information") if isinstance(content, dict) else None
    return information if isinstance(information, dict) else {}
