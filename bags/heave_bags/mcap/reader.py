"""Read a bag: messages in order, columns, pandas frames. Streaming, without ROS, whatever state the bag is in.

The first pass over the messages reads all of a bag, and shows what is lost and in which order its messages are.

>>> bag = Bag("runs/b2_calm_300")                           # doctest: +SKIP
>>> bag.frame("unit/odometry")["pose.pose.position.z"].std()  # doctest: +SKIP
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcap.records import Attachment, Channel, Schema
from numpy.typing import NDArray

from heave_bags.cdr.columns import Columns
from heave_bags.errors import BagError
from heave_bags.mcap.bounds import LATEST_TIME
from heave_bags.mcap.files import (
    OUTCOME_RECORD,
    RUN_RECORD,
    BagSummary,
    ListedFile,
    TopicSummary,
    file_counts,
    information_in_record,
    listed_files,
    read_information,
)
from heave_bags.mcap.loss import MISSING_FILE, Loss, recorded_loss
from heave_bags.mcap.read.decode import LOG_TIME, TIME, BagTopic, ColumnReader, MessageDecoder, definition
from heave_bags.mcap.read.folder import bag_of, find_files
from heave_bags.mcap.read.order import NOT_IN_ORDER, ClockWatch, Progress, SortedMessages, no_progress
from heave_bags.mcap.read.other_storage import copied, source_of
from heave_bags.mcap.read.scan import FileContents, McapScan, RawMessage
from heave_bags.mcap.read.survey import Survey, copies, in_order_of_files, match_listed, survey_file
from heave_bags.mcap.ros.qos import UNREADABLE, from_yaml

if TYPE_CHECKING:
    import pandas

_PROGRESS_EVERY = 1000
LONGEST_ARRAY = 16
"""Elements of an array that has columns of its own in a table without being asked for."""

__all__ = ["LOG_TIME", "TIME", "Bag", "BagTopic", "Progress", "RawMessage", "no_progress", "summary_of"]


@dataclass
class _Checked:
    """What a pass over all files of a bag has shown."""

    losses: list[Loss] = field(default_factory=list)  # what could not be read
    spans: dict[Path, dict[int, tuple[int, int]]] = field(default_factory=dict)  # log times of each chunk, by file [ns]
    order: str = ""  # what a reader must know of the order; "" for messages in order
    sorted: SortedMessages | None = None  # all messages, where they are in no order


class Bag:
    """A bag to read: a rosbag2 folder, a single MCAP file, or the folder of a run, which holds its bag.

    Attributes
    ----------
    path : the folder or file of the bag
    losses : what could not be read in the last pass, and what the recorder says it could not write; empty for a sound
        bag
    notes : what else a reader must know, after the last pass

    Raises BagError if there is no bag at `path`.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = place = bag_of(Path(path))
        source = source_of(place)
        self._copied = None if source is None else copied(source)
        if self._copied is not None:
            place = self._copied.path
        self._described = read_information(place if place.is_dir() else place.parent)
        self._found = find_files(place, listed_files(self._described))
        self._found.notes += self._copied.notes if self._copied is not None else []
        self.losses: list[Loss] = []
        self.notes: list[str] = []
        stated = recorded_loss(self._described)
        self._not_recorded = [] if stated is None else [stated.to_loss(self.path)]
        self._topics: dict[str, BagTopic] | None = None
        self._checked: _Checked | None = None

    @cached_property
    def stated(self) -> Mapping[str, Any]:
        """What `metadata.yaml` says of the bag, or its last file where there is none; empty if neither does."""
        return self._described or information_in_record(self._surveys[-1].contents.metadata)

    # What the bag is -----------------------------------------------------------------------------------------------

    @property
    def topics(self) -> Mapping[str, BagTopic]:
        """The topics by full name, sorted."""
        if self._topics is None:
            self._topics = self._survey()
        return self._topics

    @property
    def start_time(self) -> int:
        """Log time of the first message [ns]; 0 for an empty bag."""
        return self._spanned[0]

    @property
    def end_time(self) -> int:
        """Log time of the last message [ns]; 0 for an empty bag."""
        return self._spanned[1]

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
        """Description of the run in the bag: scenario, seed, versions, git commit; empty for bags of others."""
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
        cause = f": {self.losses[0]}" if self.losses and not self.topics else ""
        raise BagError(f"{self.path}: no topic {topic}; it has {', '.join(self.topics) or 'none'}{cause}")

    def has(self, topic: str) -> bool:
        """Return whether the bag has messages on a topic."""
        try:
            return self.topics[self.resolve(topic)].message_count > 0
        except BagError:
            return False

    # Its files -----------------------------------------------------------------------------------------------------

    @property
    def files(self) -> list[Path]:
        """Its MCAP files, in order."""
        return [survey.path for survey in self._surveys]

    @property
    def file_summaries(self) -> list[ListedFile]:
        """What is in its files, in order."""
        return [survey.summary() for survey in self._surveys]

    @cached_property
    def _surveys(self) -> list[Survey]:
        """What its files hold, in order: from their summaries, or by reading those that have none."""
        counts = file_counts(self._described)
        surveys = [survey_file(path, counts.get(path.name)) for path in self._found.files]
        repeated = copies(surveys, {part.name for part in listed_files(self._described)})
        self._found.notes += [f"{path.name} is a copy of another file of the bag: it is not read" for path in repeated]
        return in_order_of_files(
            [survey for survey in surveys if survey.path not in repeated], listed_files(self._described)
        )

    def _surveyed(self) -> list[FileContents]:
        return [survey.contents for survey in self._surveys]

    @cached_property
    def _listing(self) -> tuple[dict[Path, ListedFile], list[ListedFile]]:
        """Which file that is listed each file is, and those of a folder that are missing."""
        listed = listed_files(self.stated)
        named = {loss.file.name for loss in self._found.losses}
        matched, missing = match_listed(self._surveys, [part for part in listed if part.name not in named])
        return matched, missing if self.path.is_dir() else []

    def _check(self, progress: Progress) -> _Checked:
        """Return what a pass over all files has shown; note what could not be read, and what a reader must know."""
        if self._checked is None:
            self._checked = self._read_through(progress)
        self.losses = [*self._unread(), *self._checked.losses, *self._not_recorded]
        order = self._checked.order
        self.notes = [*self._found.notes, *([f"{self.path.name}: {order}"] if order else [])]
        return self._checked

    def _read_through(self, progress: Progress) -> _Checked:
        watch, total, before = ClockWatch(), max(self.size, 1), 0
        is_own = all(survey.contents.is_own for survey in self._surveys)  # the order is then that of its recorder
        checked = _Checked()
        for scan in self._scans():
            for block in scan.blocks():
                if not is_own:
                    watch.observe(block)
                progress(min((before + scan.position) / total, 1.0))
            checked.losses += scan.contents.losses
            checked.spans[scan.path] = scan.spans
            before += scan.path.stat().st_size
        checked.order = watch.note
        if checked.order == NOT_IN_ORDER:
            checked.sorted = SortedMessages(self.path, (block for scan in self._scans() for block in scan.blocks()))
        return checked

    def _scans(self, start: int = 0, end: int = LATEST_TIME) -> Iterator[McapScan]:
        """Yield a scan of each file, in order, without the chunks known to hold nothing from `start` to `end` [ns]."""
        matched, _ = self._listing
        is_agreed = bool(file_counts(self._described))
        numbering: dict[str, int] | None = {} if self._surveys[0].is_first else None
        for survey, previous in zip(self._surveys, (None, *self._surveys), strict=False):
            if previous is not None and survey.follows_gap(previous):
                numbering = None
            spans = self._checked.spans[survey.path] if self._checked else {}
            outside = {position for position, (first, last) in spans.items() if last < start or first > end}
            listed = matched.get(survey.path)
            expected = listed.messages if listed and is_agreed else None
            scan = McapScan(survey.path, expected=expected, numbering=numbering, passed_over=outside)
            if outside:  # the definitions may lie in what is passed over
                scan.contents.schemas |= survey.contents.schemas
                scan.contents.channels |= survey.contents.channels
            yield scan

    def _unread(self) -> list[Loss]:
        """Return the files that are not there, or hold nothing."""
        _, missing = self._listing
        absent = [
            Loss(self.path / part.name, None, MISSING_FILE, part.start, part.end, part.messages) for part in missing
        ]
        losses = [*self._found.losses, *absent]
        total = self.stated.get("message_count")
        if len(losses) == 1 and losses[0].messages is None and isinstance(total, int):
            rest = total - sum(survey.message_count for survey in self._surveys)
            losses = [replace(losses[0], messages=rest)] if rest > 0 else losses
        return losses

    @cached_property
    def _spanned(self) -> tuple[int, int]:
        spans = [survey.span for survey in self._surveys if survey.span is not None]
        return (min(span[0] for span in spans), max(span[1] for span in spans)) if spans else (0, 0)

    def _survey(self) -> dict[str, BagTopic]:
        """Return the topics, and note what could not be read to learn them."""
        topics: dict[str, BagTopic] = {}
        for survey in self._surveys:
            for channel_id, channel in survey.contents.channels.items():
                known = topics.setdefault(channel.topic, _topic(channel, survey.contents.schemas))
                known.message_count += survey.counts.get(channel_id, 0)
        unread = [*self._unread(), *(loss for contents in self._surveyed() for loss in contents.losses)]
        self.losses = [*unread, *self._not_recorded]
        self.notes = list(self._found.notes)
        return dict(sorted(topics.items()))

    # Messages ------------------------------------------------------------------------------------------------------

    def messages(
        self,
        topics: Collection[str] | None = None,
        *,
        start: int = 0,
        end: int = LATEST_TIME,
        progress: Progress = no_progress,
    ) -> Iterator[RawMessage]:
        """Yield messages of `topics`, full names or their ends, None: all, with log times from `start` to `end` [ns],
        in order.

        That is the order of their log times; that of its files where the clock of a run was reset. `progress` is called
        with the share of the bag that is read. After the pass, `losses` holds what could not be read, and `notes` what
        else a reader must know.
        """
        wanted = None if topics is None else {self.resolve(topic) for topic in topics}
        checked = self._check(lambda share: progress(0.5 * share))
        first, length = self.start_time, max(self.end_time - self.start_time, 1)
        blocks = (block for scan in self._scans(start, end) for block in scan.blocks())
        for count, message in enumerate(checked.sorted or chain.from_iterable(blocks)):
            if not count % _PROGRESS_EVERY:
                progress(min(max(0.5 + 0.5 * (message.log_time - first) / length, 0.5), 1.0))
            if start <= message.log_time <= end and (wanted is None or message.topic in wanted):
                yield message
        progress(1.0)

    def decoded(self, topics: Collection[str] | None = None, **selection: Any) -> Iterator[tuple[RawMessage, Any]]:
        """Yield messages of `topics` with their content as objects, by mcap-ros2-support; `selection` as in `messages`.

        Messages that do not fit their definition are left out and counted in `losses`. Raises BagError for a topic
        whose definition is missing or cannot be.
        """
        decoders: dict[str, MessageDecoder] = {}
        for message in self.messages(topics, **selection):
            decoder = decoders.get(message.topic)
            if decoder is None:
                decoder = decoders[message.topic] = MessageDecoder(self._defined(message.topic))
            content = decoder.decode(message.data)
            if content is not None:
                yield message, content
        self._note_misfits({topic: decoder.misfits for topic, decoder in decoders.items()})

    def _defined(self, name: str) -> BagTopic:
        """Return a topic whose definition the bag holds; raises BagError for one without."""
        topic = self.topics[self.resolve(name)]
        if not topic.schema:
            raise BagError(f"{self.path}: {topic.name} ({topic.type}) {topic.problem}")
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
            self.resolve(name): (name, ColumnReader(self._defined(name), fields, longest))
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
        return sum(path.stat().st_size for path in self._found.files)

    def frame(self, topic: str, fields: Collection[str] | None = None) -> pandas.DataFrame:
        """Return one `topic` as a pandas DataFrame with index `time` [s], the stamp of the header where there is one.

        A device outside the simulation stamps by its own clock: compare two of them by the column `log_time` [ns].
        Array fields become columns `name[0]`, `name[1]` ...; those of more than LONGEST_ARRAY elements (covariances,
        long cables) are left out unless named in `fields`.
        """
        import pandas  # noqa: PLC0415 - half a second to import, for those who want frames only

        columns = self.columns({topic: fields})[topic]
        time = columns.pop(TIME)
        flat: dict[str, NDArray[Any]] = {}
        for name, values in columns.items():
            if values.ndim == 1:
                flat[name] = values
            elif fields is not None or values.shape[1] <= LONGEST_ARRAY:
                flat |= {f"{name}[{index}]": values[:, index] for index in range(values.shape[1])}
        return pandas.DataFrame(flat, index=pandas.Index(time, name=TIME))


def _topic(channel: Channel, schemas: Mapping[int, Schema]) -> BagTopic:
    schema = schemas.get(channel.schema_id)
    text, problem = definition(channel, schema)
    try:
        qos = from_yaml(channel.metadata.get("offered_qos_profiles", ""))
    except UNREADABLE:
        qos = ()
    return BagTopic(
        name=channel.topic,
        type=schema.name if schema else "",
        qos=qos,
        type_hash=channel.metadata.get("topic_type_hash", ""),
        schema=text,
        problem=problem,
    )


def summary_of(bag: Bag) -> BagSummary:
    """Return what a bag's `metadata.yaml` should say, from the files themselves."""
    topics: list[TopicSummary] = list(bag.topics.values())
    return BagSummary(bag.file_summaries, topics, bag.run, bag.ros_distro)
