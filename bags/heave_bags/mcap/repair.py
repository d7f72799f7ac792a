"""Repair: a damaged bag becomes a sound one with all that can still be read; an unindexed folder gets its
`metadata.yaml` again.
"""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path

from heave_bags.errors import BagError
from heave_bags.mcap.bag_writer import Attachment, BagWriter
from heave_bags.mcap.files import METADATA_RECORD, OUTCOME_RECORD, RUN_RECORD, write_metadata
from heave_bags.mcap.loss import Loss, remarks
from heave_bags.mcap.reader import Bag, Progress, no_progress, summary_of


@dataclass(frozen=True)
class Repaired:
    """What a repair has saved: `folder` of the new bag, number of its `messages`, `losses`, `notes` on its order."""

    folder: Path
    messages: int
    losses: tuple[Loss, ...]
    notes: tuple[str, ...] = ()

    def __str__(self) -> str:
        head = f"{self.folder}: {self.messages} messages recovered"
        return "\n".join([head, *remarks(self.notes, self.losses)])


def repair(source: str | Path, output: str | Path, *, progress: Progress = no_progress) -> Repaired:
    """Write everything of a bag that can be read to a new, sound and indexed one; the source stays as it is.

    Messages keep their bytes and times, and come in the order in which the bag is read. `progress` is called with the
    share done. Raises BagError if there is no bag at `source` or `output` exists.
    """
    bag = Bag(source)
    attachments = [Attachment(name, found.media_type, found.data) for name, found in bag.attached.items()]
    others = [record for record in bag.metadata if record[0] not in (METADATA_RECORD, RUN_RECORD, OUTCOME_RECORD)]
    writer = BagWriter(Path(output), run=bag.run, attachments=attachments, ros_distro=bag.ros_distro, records=others)
    for topic in bag.topics.values():
        writer.add_foreign_topic(topic, topic.schema)
    count = 0
    for message in bag.messages(progress=progress):
        writer.write(message.topic, message.log_time, message.data, publish_time=message.publish_time)
        count += 1
    lost = "; ".join(str(loss) for loss in bag.losses)
    writer.close({**bag.outcome, "repaired_from": str(bag.path.name), **({"lost": lost} if lost else {})})
    return Repaired(Path(output), count, tuple(bag.losses), tuple(bag.notes))


def reindex(folder: str | Path) -> Bag:
    """Write `metadata.yaml` of a bag again from its files; return the bag, whose `losses` name files that hold nothing.

    Raises BagError if `folder` is not a bag folder, or if a file in it is damaged: `ros2 bag` could not open it, the
    repaired one can be opened.
    """
    bag = Bag(folder)
    if not bag.path.is_dir():
        raise BagError(f"{bag.path}: only a bag folder has a metadata.yaml")
    summary = summary_of(bag)
    damage = [str(loss) for loss in bag.losses if loss.file in bag.files]
    if damage:
        command = f"heave repair {shlex.quote(str(bag.path))} --output {shlex.quote(f'{bag.path}_repaired')}"
        raise BagError(f"{damage[0]}; repair the bag instead: {command}")
    if bag.losses:
        summary.custom_data = {**summary.custom_data, "lost": "; ".join(str(loss) for loss in bag.losses)}
    write_metadata(bag.path, summary)
    return bag
