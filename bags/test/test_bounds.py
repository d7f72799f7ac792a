"""What a file may demand is bounded: in bytes, in time."""

import resource
import subprocess
import sys
from pathlib import Path

import pytest
from heave_bags.mcap.bounds import LARGEST_RECORD, BoundError, unpack, unpack_part
from heave_bags.mcap.reader import Bag
from heave_node.cdr.layout import LayoutError, MessageLayouts
from hostile_bags import hostile_files, write_hostile_bags

MEMORY = 500 << 20
"""Bytes of private memory that a process may use on any of the bags below."""

READ = """
import resource, sys
resource.setrlimit(resource.RLIMIT_DATA, ({memory}, {memory}))
resource.setrlimit(resource.RLIMIT_CPU, (60, 60))
sys.path.insert(0, {tests!r})
from pathlib import Path
from heave_bags.errors import BagError
from heave_bags.mcap.reader import Bag
from memory import peak_memory
for folder in sorted(Path({bags!r}).iterdir()):
    try:
        bag = Bag(folder)
        read = sum(1 for _ in bag.messages())
        losses = [str(loss) for loss in bag.losses]
        for topic in bag.topics:
            try:
                bag.frame(topic)
                sum(1 for _ in bag.decoded([topic]))
            except BagError as error:
                losses.append(str(error))
    except BagError as error:
        read, losses = 0, [str(error)]
    assert all("\\n" not in text for text in losses), losses
    print(folder.name, read, losses[:1])
print("peak", peak_memory())
"""


def test_no_hostile_bag_costs_more_memory_or_time_than_it_may_and_none_ends_in_a_traceback(tmp_path):
    write_hostile_bags(tmp_path / "bags")
    script = READ.format(memory=MEMORY, bags=str(tmp_path / "bags"), tests=str(Path(__file__).parent))
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == len(hostile_files()) + 2 + 1
    assert int(lines[-1].split()[1]) < MEMORY


@pytest.mark.parametrize("compression", ["zstd", "lz4", ""])
def test_a_chunk_that_promises_too_much_is_refused_before_it_is_unpacked(compression):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(BoundError, match="are allowed"):
        unpack(compression, b"", LARGEST_RECORD + 1)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 10_000


def test_a_chunk_that_holds_another_number_of_bytes_than_it_says_is_refused():
    with pytest.raises(ValueError, match="fewer bytes"):
        unpack("", b"abc", 4)
    with pytest.raises(ValueError, match="more bytes"):
        unpack("", b"abc", 2)
    with pytest.raises(ValueError, match="unknown compression"):
        unpack("rle", b"abc", 3)


def test_what_cannot_be_unpacked_in_part_gives_nothing():
    assert unpack_part("zstd", b"no frame at all") == b""
    assert unpack_part("lz4", b"no frame at all") == b""
    assert unpack_part("rle", b"abc") == b""
    assert unpack_part("", b"abc") == b"abc"


def test_a_definition_without_an_end_is_refused():
    with pytest.raises(LayoutError, match="nests types"):
        MessageLayouts("p/msg/T", "T a\n")


def test_a_sequence_longer_than_its_message_is_refused_at_once():
    layouts = MessageLayouts("p/msg/A", "E[] a\n" + "=" * 80 + "\nMSG: p/E\nuint8[0] nothing\n")
    with pytest.raises(LayoutError, match="4294967295 elements"):
        layouts.of(b"\x00\x01\x00\x00\xff\xff\xff\xff")


def test_a_type_from_a_bag_is_never_taken_for_a_module_to_import(tmp_path):
    bags = write_hostile_bags(tmp_path)
    for name in ("a_type_that_is_a_module", "a_type_that_is_a_path"):
        list(Bag(bags[name]).messages())
    assert "antigravity" not in sys.modules
