"""Writes a rosbag2 folder of MCAP files: topics with definitions and QoS, splits, attachments, `metadata.yaml`."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

from heave_node.cdr.definitions import DefinitionError, schema_text, type_hash

from heave_bags.cdr.canonical import Canonical
from heave_bags.errors import BagError, StorageError
from heave_bags.mcap.bounds import LARGEST_MESSAGE
from heave_bags.mcap.files import (
    METADATA_KEY,
    METADATA_RECORD,
    OUTCOME_RECORD,
    RECORDING_MARK,
    RUN_RECORD,
    BagSummary,
    ListedFile,
    TopicSummary,
    file_name,
    force_metadata,
    write_metadata,
)
from heave_bags.mcap.loss import RecordedLoss
from heave_bags.mcap.reader import Bag, summary_of
from heave_bags.mcap.ros.qos import OfferedQos, to_yaml
from heave_bags.mcap.storage import DirectStorage, Storage
from heave_bags.mcap.writer import ChunkPolicy, McapWriter

DESCRIPTION_PERIOD = 1.0
"""Wall time between two updates of an unfinished bag's `metadata.yaml` [s]."""


@dataclass(frozen=True)
class Attachment:
    """A file carried inside a bag, such as the scenario: its `name`, `media_type` and `data`."""

    name: str
    media_type: str
    data: bytes


@dataclass(frozen=True)
class BagPolicy:
    """How a bag is written."""

    chunks: ChunkPolicy = field(default_factory=ChunkPolicy)  # size, span and compression of chunks
    max_file_bytes: int = 0  # a new file is started after this many bytes; 0: never
    max_file_span: int = 0  # a new file is started after this much log time [ns]; 0: never


@dataclass
class _Topic:
    summary: TopicSummary
    schema: str
    canonical: Callable[[bytes], bytes] | None = None
    channel: int = 0  # id in the present file; 0: not yet registered there


@dataclass
class _Lack:
    """What is known of messages that a bag should hold and does not."""

    refusal: StorageError | None = None  # of the disk; from then on nothing is written
    loss: RecordedLoss | None = None  # what is missing
    saved: BagSummary | None = None  # what the bag holds, once it was closed without being complete

    def to_custom_data(self) -> dict[str, str]:
        """Return the loss as the bag states it; nothing where there is none."""
        return self.loss.to_custom_data() if self.loss else {}


class BagWriter:
    """Writes one bag. Not thread-safe.

    Parameters
    ----------
    folder : of the bag
    policy : chunks and splits
    run : what the bag records about itself, in metadata records and `metadata.yaml`
    attachments : files carried in each file of the bag
    ros_distro : for `metadata.yaml`
    records : further metadata records, as name and values
    opener : makes the storage of each file
    closing_attachments : gives what is attached at the end

    Raises BagError if the folder exists already, or a topic is used that was not added; StorageError if the
    disk refuses. After a StorageError nothing more can be written, but `close` still leaves a readable bag.
    """

    def __init__(
        self,
        folder: Path,
        *,
        policy: BagPolicy | None = None,
        run: Mapping[str, str] | None = None,
        attachments: Sequence[Attachment] = (),
        ros_distro: str = "",
        records: Sequence[tuple[str, Mapping[str, str]]] = (),
        opener: Callable[[Path], Storage] = DirectStorage,
        closing_attachments: Callable[[], Sequence[Attachment]] = tuple,
    ) -> None:
        self.folder = folder
        self._policy = policy or BagPolicy()
        self._run = dict(run or {})
        self._attachments = tuple(attachments)
        self._records = tuple(records)
        self._opener = opener
        self._closing_attachments = closing_attachments
        self._topics: dict[str, _Topic] = {}
        self._schema_ids: dict[str, int] = {}
        self._closed_files: list[ListedFile] = []
        self._ros_distro = ros_distro
        self._last_time = 0
        self._lack = _Lack()
        self._describe_at = 0.0
        self._has_new_topics = False
        self.closed = False
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            raise BagError(f"{folder} exists already: a bag needs a new folder") from None
        self._open()

    def _open(self) -> None:
        self._file_name = file_name(self.folder, len(self._closed_files))
        self._file = self._opener(self.folder / self._file_name)
        self._writer = McapWriter(self._file, chunks=self._policy.chunks)
        self._is_open = True
        self._schema_ids = {}
        for topic in self._topics.values():
            topic.channel = 0
        self._writer.add_metadata(METADATA_RECORD, {METADATA_KEY: self.summary().to_record()})
        if self._run:
            self._writer.add_metadata(RUN_RECORD, self._run)
        for name, values in self._records if not self._closed_files else ():
            self._writer.add_metadata(name, values)
        for attachment in self._attachments:
            self._writer.add_attachment(attachment.name, attachment.media_type, attachment.data)
        self._describe()

    def _describe(self) -> None:
        """Write `metadata.yaml`, so that others can open a bag that is being written or was never completed."""
        self._file.describe(self.summary().to_yaml().encode())
        self._describe_at = time.monotonic() + DESCRIPTION_PERIOD
        self._has_new_topics = False

    def add_topic(self, name: str, message_type: str, qos: Sequence[OfferedQos] = ()) -> str:
        """Make the topic `name` known, by the definition of its `message_type` that is installed here, with the `qos`
        that its publishers offer.

        Its messages are written without what middleware leaves in their padding. Returns "" or one line that says why
        its bag cannot be decoded elsewhere.
        """
        if name in self._topics:
            return ""
        try:
            schema, problem = schema_text(message_type), ""
        except DefinitionError as error:
            schema, problem = "", f"{name} is recorded without its definition: {error}"
        summary = TopicSummary(name, message_type, tuple(qos), type_hash(message_type))
        self._topics[name] = _Topic(summary, schema, Canonical(message_type, schema) if schema else None)
        self._has_new_topics = True  # readers of others know only the topics of metadata.yaml
        return problem

    def add_foreign_topic(self, summary: TopicSummary, schema: str) -> None:
        """Make the topic of `summary` known by the definition that another bag holds, `schema`.

        Its messages are written as they are.
        """
        own = TopicSummary(summary.name, summary.type, summary.qos, summary.type_hash)
        self._topics.setdefault(summary.name, _Topic(own, schema))

    def write(self, topic: str, log_time: int, data: bytes, *, publish_time: int | None = None) -> None:
        """Write one serialised message, `data`, of a `topic` that is known, at its `log_time` and `publish_time` [ns];
        None: the same.
        """
        try:
            known = self._topics[topic]
        except KeyError:
            raise BagError(f"topic {topic} was not added to the bag {self.folder}") from None
        if len(data) > LARGEST_MESSAGE:
            raise BagError(f"a message of {len(data)} bytes on {topic} is larger than a bag allows ({LARGEST_MESSAGE})")
        if self._must_split(log_time):
            self.split()
        if not known.channel:
            self._register(known)
        known.summary.message_count += 1
        self._last_time = log_time
        if known.canonical is not None:
            data = known.canonical(data)
        published = log_time if publish_time is None else publish_time
        sequence = known.summary.message_count & 0xFFFFFFFF
        if self._lack.refusal is not None:
            raise self._lack.refusal
        try:
            self._writer.write(known.channel, log_time, data, publish_time=published, sequence=sequence)
        except StorageError as error:
            self._lack.refusal = error
            raise

    @contextmanager
    def _remembering_refusal(self) -> Iterator[None]:
        """Remember that the disk has refused something: from then on the bag is not what was written."""
        if self._lack.refusal is not None:
            raise self._lack.refusal
        try:
            yield
        except StorageError as error:
            self._lack.refusal = error
            raise

    def _must_split(self, log_time: int) -> bool:
        writer, policy = self._writer, self._policy
        if not (policy.max_file_bytes or policy.max_file_span) or not writer.message_count:
            return False
        too_big = 0 < policy.max_file_bytes <= writer.size + writer.pending_bytes
        return too_big or 0 < policy.max_file_span <= log_time - writer.start_time

    def _register(self, topic: _Topic) -> None:
        name = topic.summary.type
        if name not in self._schema_ids:
            encoding = "ros2msg" if topic.schema else ""
            self._schema_ids[name] = self._writer.add_schema(name, encoding, topic.schema.encode())
        metadata = {
            "offered_qos_profiles": to_yaml(topic.summary.qos),
            "topic_type_hash": topic.summary.type_hash,
        }
        topic.channel = self._writer.add_channel(topic.summary.name, self._schema_ids[name], metadata)

    def acknowledge(self) -> None:
        """Journal what was written since: it survives a crash of this process."""
        with self._remembering_refusal():
            self._file.acknowledge(self._writer.take_pending())
            if time.monotonic() >= self._describe_at or self._has_new_topics:
                self._describe()

    def split(self) -> None:
        """Complete the present file and begin the next."""
        self._complete_file()
        self._open()

    def _complete_file(self) -> None:
        writer = self._writer
        writer.close_chunk()
        self._closed_files.append(self._file_summary())
        self._is_open = False
        writer.add_metadata(METADATA_RECORD, {METADATA_KEY: self.summary().to_record()})
        writer.finish()
        self._file.close()

    def _file_summary(self) -> ListedFile:
        writer = self._writer
        return ListedFile(self._file_name, writer.start_time, writer.end_time, writer.message_count)

    def summary(self) -> BagSummary:
        """Return what `metadata.yaml` would say now."""
        files = [*self._closed_files, self._file_summary()] if self._is_open else list(self._closed_files)
        topics = [self._topics[name].summary for name in sorted(self._topics)]
        mark = RECORDING_MARK if self._is_open else {}
        lost = self._lack.to_custom_data()
        return BagSummary(files, topics, {**self._run, **mark, **lost}, self._ros_distro)

    def note_loss(self, reason: str, messages: int, start: int, end: int | None = None) -> None:
        """Note for what `reason` so many `messages` that belong into the bag are not in it: `metadata.yaml` says so,
        after `close` too.

        They lie between the log times `start` and `end` [ns]; None: at one time.
        """
        self._lack.loss = RecordedLoss(reason, messages, start, start if end is None else end).joined(self._lack.loss)
        if self._lack.saved is not None:
            self._force_metadata(self._lack.saved)

    def close(self, outcome: Mapping[str, str] | None = None) -> None:
        """Complete the bag; `outcome` goes into a metadata record of the last file. Closing twice does nothing.

        Raises StorageError if the disk has refused something; the bag can be read all the same, and the message
        says what it lacks.
        """
        if self.closed:
            return
        self.closed = True
        try:
            with self._remembering_refusal():
                self._complete(outcome)
        except (StorageError, OSError) as error:
            reason = str(error) if isinstance(error, StorageError) else f"{self.folder}: {error.strerror}"
            raise StorageError(f"{reason}; {self._salvage()}") from error

    def _complete(self, outcome: Mapping[str, str] | None) -> None:
        for name in sorted(self._topics):
            if not self._topics[name].channel:
                self._register(self._topics[name])
        for attachment in self._closing_attachments():
            self._writer.add_attachment(attachment.name, attachment.media_type, attachment.data)
        if outcome:
            self._writer.add_metadata(OUTCOME_RECORD, outcome)
        self._complete_file()
        write_metadata(self.folder, self.summary())

    def _salvage(self) -> str:
        """Close what could not be completed, describe it as it is, and say what it lacks."""
        with suppress(StorageError, OSError):
            self._file.close()
        written = sum(topic.summary.message_count for topic in self._topics.values())
        try:
            saved = Bag(self.folder)
            self._lack.saved = summary_of(saved)
            lost, first = written - saved.message_count, saved.end_time
        except BagError:
            return f"its {written} messages were lost with the folder"
        if not lost:
            self._force_metadata(self._lack.saved)
            return "no message was lost"
        self.note_loss(self._reason(), lost, first, self._last_time)
        return f"{lost} messages from {first * 1e-9:.3f} s to {self._last_time * 1e-9:.3f} s were lost"

    def _reason(self) -> str:
        words = str(self._lack.refusal) if self._lack.refusal else "the bag could not be completed"
        return words.replace(f"{self.folder}/", "").replace(f"{self.folder}: ", "")

    def _force_metadata(self, saved: BagSummary) -> None:
        """Describe the bag as it was `saved`, and what it lacks."""
        lost = self._lack.to_custom_data()
        with suppress(OSError):
            force_metadata(self.folder, replace(saved, custom_data={**saved.custom_data, **lost}).to_yaml().encode())
