"""Bags made to hurt: files that ask for more than they hold, definitions without an end, values that mean nothing."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from functools import cache
from itertools import pairwise
from pathlib import Path

import lz4.frame
import zstandard
from heave_bags.mcap.summary import MAGIC, interim_ending
from heave_node.cdr.definitions import schema_text
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Footer, Header, McapRecord, Message, Metadata, Schema, Statistics

GIGABYTE = 1 << 30
HEAD = b"\x00\x01\x00\x00"
STAMP = struct.pack("<iI", 1, 0)
FRAME = struct.pack("<I", 6) + b"world\0" + bytes(2)
HEADER = STAMP + FRAME


def encoded(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()


def mcap(*parts: bytes, ending: bytes | None = None, library: str = "somebody") -> bytes:
    ending = interim_ending() if ending is None else ending
    return b"".join([MAGIC, encoded(Header(profile="ros2", library=library)), *parts, ending])


def chunk(records: bytes, *, packed: bytes | None = None, compression: str = "zstd", size: int | None = None) -> bytes:
    packed = zstandard.compress(records) if packed is None else packed
    whole = Chunk(
        compression=compression,
        data=packed,
        message_start_time=0,
        message_end_time=10**9,
        uncompressed_crc=zlib.crc32(records) if size is None else 0,
        uncompressed_size=len(records) if size is None else size,
    )
    return encoded(whole)


def topic(
    name: str = "/unit/odometry",
    kind: str = "nav_msgs/msg/Odometry",
    text: str | None = None,
    *,
    number: int = 1,
    qos: str = "",
) -> bytes:
    text = schema_text(kind) if text is None else text
    schema = Schema(id=number, name=kind, encoding="ros2msg", data=text.encode())
    metadata = {"offered_qos_profiles": qos}
    channel = Channel(id=number, topic=name, message_encoding="cdr", schema_id=number, metadata=metadata)
    return encoded(schema) + encoded(channel)


def message(data: bytes, *, number: int = 1, time: int = 10**9) -> bytes:
    return encoded(Message(channel_id=number, log_time=time, publish_time=time, sequence=0, data=data))


def messages(data: bytes, count: int = 300, **channel: int) -> bytes:
    return b"".join(message(data, time=50_000_000 * index, **channel) for index in range(1, count + 1))


def typed(text: str, data: bytes) -> bytes:
    """Return a file with some messages of a definition on a topic that is analysed."""
    return mcap(chunk(topic(kind="p/msg/Root", text=text) + messages(HEAD + data)))


@cache
def hostile_files() -> dict[str, bytes]:
    """Return files by what is wrong with them."""
    zeros = bytes(1 << 20)
    streamed = zstandard.ZstdCompressor().compressobj()
    bomb = b"".join(streamed.compress(zeros) for _ in range(GIGABYTE // len(zeros))) + streamed.flush()
    sized = zstandard.ZstdCompressor().compress(bytes(GIGABYTE))
    deep_yaml = "[" * 100_000
    laughs = "a: &a [x, x]\n" + "".join(f"{b}: &{b} [*{a}, *{a}, *{a}, *{a}]\n" for a, b in pairwise("abcdefghi"))
    chain = "T0 a\n" + "".join(f"{'=' * 80}\nMSG: p/T{n}\nT{n + 1} a\n" for n in range(500))
    chain += f"{'=' * 80}\nMSG: p/T500\nuint8 a\n"
    empties = f"E[] a\n{'=' * 80}\nMSG: p/E\n# nothing\n"
    point = "heave_msgs/msg/PointMotion"
    return {
        "packed_bomb_of_stated_size": mcap(chunk(b"", packed=sized, size=GIGABYTE)),
        "packed_bomb_that_understates_its_size": mcap(chunk(b"", packed=sized, size=100)),
        "packed_bomb_without_a_size": mcap(chunk(b"", packed=bomb, size=60 << 20)),
        "packed_bomb_cut_off": mcap(chunk(b"", packed=bomb, size=60 << 20))[:-200],
        "lz4_bomb": mcap(chunk(b"", packed=lz4.frame.compress(bytes(GIGABYTE)), compression="lz4", size=1000)),
        "unknown_compression": mcap(chunk(b"x", compression="middle-out")),
        "record_of_an_exabyte": mcap(struct.pack("<BQ", Opcode.ATTACHMENT, 1 << 60) + bytes(100)),
        "record_of_all_there_is": mcap(struct.pack("<BQ", Opcode.CHUNK, (1 << 64) - 1) + bytes(100)),
        "message_longer_than_its_chunk": mcap(chunk(topic() + message(b"")[:1] + struct.pack("<Q", 1 << 62))),
        "attachment_longer_than_the_file": mcap(
            encoded(Attachment(0, 0, "a", "b", b"c")).replace(struct.pack("<Q", 1), struct.pack("<Q", 1 << 50))
        ),
        "summary_that_lies_behind_the_end": mcap(ending=_ending(1 << 50)),
        "summary_that_is_the_whole_file": mcap(chunk(topic() + messages(HEAD)), ending=_ending(8)),
        "statistics_that_lie": _lying_statistics(),
        "type_that_contains_itself": typed("T a\n" + "=" * 80 + "\nMSG: p/T\nT a\n", bytes(40)),
        "types_that_contain_each_other": typed(
            f"p/A a\n{'=' * 80}\nMSG: p/A\np/B b\n{'=' * 80}\nMSG: p/B\np/A a\n", b""
        ),
        "types_nested_500_deep": typed(chain, bytes(10)),
        "empty_sequence_of_2_32": typed(empties, struct.pack("<I", 0xFFFFFFFF)),
        "empty_array_of_2_32": typed(empties.replace("E[] a", "E[4294967295] a"), bytes(8)),
        "numbers_of_2_32": typed("float64[] a", struct.pack("<I", 0xFFFFFFFF) + bytes(8)),
        "text_of_2_32": typed("string a", struct.pack("<I", 0xFFFFFFFF) + b"a\0"),
        "wide_text_of_2_32": typed("wstring a", struct.pack("<I", 0xFFFFFFFF) + b"a\0"),
        "array_longer_than_any_memory": typed("float64[999999999999999999] a", bytes(8)),
        "definition_of_a_field_with_a_long_name": typed(f"float64 {'a' * 500_000}", bytes(8)),
        "definition_that_is_no_text": mcap(
            chunk(encoded(Schema(1, b"\xff\xfe\x00" * 50, "ros2msg", "nav_msgs/msg/Odometry")) + topic()[-60:])
        ),
        "definition_that_lacks_a_type": typed("nowhere/Thing a\nfloat64 b", bytes(16)),
        "definition_that_is_empty": typed("", bytes(1)),
        "messages_of_no_definition": mcap(chunk(messages(HEAD + bytes(40)))),
        "messages_of_nothing": mcap(chunk(topic() + messages(b""))),
        "messages_of_noise": mcap(chunk(topic() + messages(HEAD + zlib.compress(zeros)))),
        "deep_yaml_in_a_channel": mcap(chunk(topic(qos=deep_yaml) + messages(HEAD + HEADER))),
        "aliases_in_a_channel": mcap(chunk(topic(qos=laughs) + messages(HEAD + HEADER))),
        "qualities_of_service_that_are_not": mcap(
            chunk(
                topic("/boom_tip", point, qos="- {depth: 1e400, history: {a: b}}") + messages(HEAD + HEADER + bytes(96))
            )
        ),
        "deep_yaml_in_the_scenario": mcap(*_with_run("scenario.yaml", deep_yaml)),
        "aliases_in_the_parameters": mcap(*_with_run("parameters.yaml", laughs)),
        "a_scenario_of_nonsense": mcap(
            *_with_run("scenario.yaml", "winch_controller: {ros__parameters: {law: [1, {}]}}")
        ),
        "words_where_numbers_belong": mcap(
            encoded(Metadata("heave_run", {"transient_s": "later", "tick_period_s": "nan"})),
            encoded(Metadata("heave_outcome", {"real_time_factor": "fast", "loop_age_p99_s": ""})),
            chunk(topic("/boom_tip", point) + messages(HEAD + HEADER + bytes(72))),
        ),
        "an_endless_transient": mcap(
            encoded(Metadata("heave_run", {"transient_s": "inf"})),
            chunk(topic("/boom_tip", point) + messages(HEAD + HEADER + bytes(72))),
        ),
        "times_at_the_end_of_all_days": mcap(
            chunk(topic("/boom_tip", point) + message(HEAD + HEADER + bytes(72), time=(1 << 64) - 1) * 20)
        ),
        "times_of_the_year_2200": mcap(
            chunk(topic("/boom_tip", point) + message(HEAD + HEADER + bytes(72), time=(1 << 63) - 2) * 20)
        ),
        "stamps_before_all_days": mcap(
            chunk(
                topic("/boom_tip", point)
                + messages(HEAD + struct.pack("<iI", -(1 << 31), 0xFFFFFFFF) + FRAME + bytes(72))
            )
        ),
        "values_that_are_no_numbers": mcap(
            chunk(topic("/boom_tip", point) + messages(HEAD + HEADER + struct.pack("<d", float("nan")) * 9))
        ),
        "a_type_that_is_a_module": mcap(
            chunk(topic(kind="antigravity/msg/fly", text="float64 a") + messages(HEAD + bytes(8)))
        ),
        "a_type_that_is_a_path": mcap(
            chunk(topic(kind="../../etc/passwd", text="float64 a") + messages(HEAD + bytes(8)))
        ),
        "a_type_without_a_package": mcap(chunk(topic(kind="Odometry", text="float64 a") + messages(HEAD + bytes(8)))),
        "a_topic_that_is_none": mcap(chunk(topic("/a b//c$\n", point) + messages(HEAD + HEADER + bytes(72)))),
        "nothing": b"",
        "only_a_magic": MAGIC,
        "only_two_magics": MAGIC + MAGIC,
    }


def _ending(summary_start: int) -> bytes:
    return interim_ending()[:13] + encoded(Footer(summary_start, 0, 0)) + MAGIC


def _lying_statistics() -> bytes:
    data = chunk(topic() + messages(HEAD + HEADER))
    start = len(mcap(data, ending=interim_ending()[:13]))
    counts = {1: (1 << 64) - 1, 7: 5}
    statistics = Statistics(
        attachment_count=0,
        channel_count=1,
        channel_message_counts=counts,
        chunk_count=1,
        message_count=sum(counts.values()) & ((1 << 64) - 1),
        metadata_count=0,
        message_start_time=(1 << 64) - 1,
        message_end_time=0,
        schema_count=1,
    )
    summary = topic() + encoded(statistics) + encoded(Footer(start, 0, 0)) + MAGIC
    return mcap(data, ending=interim_ending()[:13] + summary)


def _with_run(attachment: str, text: str) -> list[bytes]:
    return [
        encoded(Attachment(0, 0, attachment, "application/yaml", text.encode())),
        chunk(topic("/boom_tip", "heave_msgs/msg/PointMotion") + messages(HEAD + HEADER + bytes(72))),
    ]


def write_hostile_bags(folder: Path) -> Mapping[str, Path]:
    """Write each hostile file as a bag of its own, and one more whose metadata.yaml is the hostile part."""
    bags: dict[str, Path] = {}
    for name, data in hostile_files().items():
        bags[name] = folder / name
        bags[name].mkdir(parents=True)
        (bags[name] / f"{name}_0.mcap").write_bytes(data)
    for name, text in {"deep_metadata": "[" * 100_000, "metadata_of_noise": "\x01{[: \ud7ff"}.items():
        bags[name] = folder / name
        bags[name].mkdir(parents=True)
        (bags[name] / f"{name}_0.mcap").write_bytes(hostile_files()["words_where_numbers_belong"])
        (bags[name] / "metadata.yaml").write_text(text)
    return bags
