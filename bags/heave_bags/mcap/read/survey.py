"""What a file of a bag holds, from its summary; from the file itself where it has none."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import Attachment, Metadata
from mcap.summary import Summary

from heave_bags.mcap.bounds import LARGEST_RECORD
from heave_bags.mcap.files import ListedFile, information_in_record, listed_files
from heave_bags.mcap.read.scan import FileContents, McapScan, attachment_problem, is_of_this_project
from heave_bags.mcap.records import UNPARSEABLE, RecordFile, parse
from heave_bags.mcap.summary import MAGIC, read_summary


@dataclass
class Survey:
    """What a file holds."""

    path: Path  # of the file
    contents: FileContents  # beside messages
    counts: dict[int, int]  # messages by channel
    span: tuple[int, int] | None  # first and last log time [ns]; None without messages

    @property
    def message_count(self) -> int:
        """Messages in the file."""
        return sum(self.counts.values())

    def summary(self) -> ListedFile:
        """Return the line of `metadata.yaml` on the file."""
        return ListedFile(self.path.name, *(self.span or (0, 0)), self.message_count)

    @cached_property
    def number(self) -> int | None:
        """Its number in the bag, from 0, as it says itself; None where it does not."""
        listed = listed_files(information_in_record(self.contents.metadata))
        return len(listed) - 1 if listed else None

    @property
    def is_first(self) -> bool:
        """Whether the file is the first of its bag."""
        return self.number == 0 if self.number is not None else _is_named_first(self.path)

    def follows_gap(self, before: Survey) -> bool:
        """Return whether files are missing between the file `before` and this one, by their numbers."""
        return self.number is not None and before.number is not None and self.number != before.number + 1


def survey_file(path: Path, expected: int | None) -> Survey:
    """Learn what the file at `path` holds, which has `expected` messages; None: that is not known."""
    with RecordFile(path) as file:
        summary = read_summary(file)
        if summary is not None and summary.channels and (stated := _stated(summary)):
            contents = FileContents(summary.schemas, summary.channels, complete=True)
            contents.is_own = _is_own(file)
            positions = [one.offset for one in summary.metadata_indexes]
            positions += [one.offset for one in summary.attachment_indexes]
            if _take_records(file, positions, contents):
                return Survey(path, contents, *stated)
        is_first = _is_first(file)
    return _read_through(path, expected, is_first=is_first)


def _stated(summary: Summary) -> tuple[dict[int, int], tuple[int, int] | None] | None:
    """Return the messages by channel, first and last log time [ns]; None where the numbers do not agree."""
    found = summary.statistics
    if found is None or sum(found.channel_message_counts.values()) != found.message_count:
        return None
    return found.channel_message_counts, (
        (found.message_start_time, found.message_end_time) if found.message_count else None
    )


def _is_own(file: RecordFile) -> bool:
    header = file.record_at(len(MAGIC))
    return header is not None and header.opcode == Opcode.HEADER and is_of_this_project(file.body(header))


def _is_first(file: RecordFile) -> bool:
    """Return whether a file without a summary is the first of its bag, by the record with which its recorder began."""
    header = file.record_at(len(MAGIC))
    opening = None if header is None else file.record_at(header.end)
    contents = FileContents()
    if opening is not None and opening.opcode == Opcode.METADATA and _take_records(file, [opening.position], contents):
        return Survey(file.path, contents, {}, None).is_first
    return _is_named_first(file.path)


def _is_named_first(path: Path) -> bool:
    return path.name.split(".", 1)[0].endswith("_0")


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


def _read_through(path: Path, expected: int | None, *, is_first: bool) -> Survey:
    scan = McapScan(path, expected=expected, numbering={} if is_first else None)
    times = [message.log_time for block in scan.blocks() for message in (min(block, key=_time), max(block, key=_time))]
    span = (min(times), max(times)) if times else None
    return Survey(path, scan.contents, scan.counts, span)


_time = attrgetter("log_time")


def in_order_of_files(surveys: Sequence[Survey], listed: Sequence[ListedFile]) -> list[Survey]:
    """Return the `surveys` of a bag's files in order: by the files' own numbers, as `listed`, or by their log times."""
    numbers = [survey.number for survey in surveys]
    if None not in numbers and len(set(numbers)) == len(numbers):
        return sorted(surveys, key=lambda survey: survey.number or 0)
    places = {part.name: place for place, part in enumerate(listed)}
    if all(survey.path.name in places for survey in surveys):
        return sorted(surveys, key=lambda survey: places[survey.path.name])
    return sorted(surveys, key=lambda survey: (survey.span or (math.inf,), survey.path.name))


def match_listed(
    surveys: Sequence[Survey], listed: Sequence[ListedFile]
) -> tuple[dict[Path, ListedFile], list[ListedFile]]:
    """Return which `listed` file each of `surveys` is, by name or, if renamed, by first message; and those missing."""
    by_name = {part.name: part for part in listed}
    matched = {survey.path: by_name.pop(survey.path.name) for survey in surveys if survey.path.name in by_name}
    for survey in surveys:
        start = survey.span[0] if survey.span else None
        same = [part for part in by_name.values() if part.start == start or part.start is None or not part.messages]
        if survey.path not in matched and same:
            part = next((part for part in same if part.start == start), same[0])
            matched[survey.path] = by_name.pop(part.name)
    return matched, [part for part in by_name.values() if part.messages != 0]


def copies(surveys: Sequence[Survey], listed: Collection[str]) -> set[Path]:
    """Return which files of `surveys` hold the messages of another, by times and counts; `listed` ones go first."""
    found: dict[object, Path] = {}
    repeated: set[Path] = set()
    for survey in sorted(surveys, key=lambda survey: (survey.path.name not in listed, survey.path.name)):
        topics = {survey.contents.channels[channel].topic: count for channel, count in survey.counts.items()}
        key = (survey.span, tuple(sorted(topics.items())))
        if survey.span is not None and found.setdefault(key, survey.path) is not survey.path:
            repeated.add(survey.path)
    return repeated
