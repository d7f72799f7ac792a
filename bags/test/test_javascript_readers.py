"""The readers that Foxglove is made of (@mcap/core, @foxglove/rosmsg2-serialization) decode every message of
every type.

They come from npm: `npm ci` in the folder `javascript` beside this file installs them.
"""

import json
import math
import shutil
import subprocess
from pathlib import Path

import pytest
from heave_bags.mcap.bag_writer import BagPolicy
from heave_bags.mcap.reader import Bag
from heave_bags.mcap.writer import ChunkPolicy
from made_up_run import MadeUpRun

FOLDER = Path(__file__).parent / "javascript"
NODE = shutil.which("node")

pytestmark = pytest.mark.skipif(
    NODE is None or not (FOLDER / "node_modules").is_dir(), reason="needs node and `npm ci` in bags/test/javascript"
)


def decode(files: list[Path]) -> dict:
    done = subprocess.run(
        [str(NODE), "decode_bag.mjs", *map(str, files)], cwd=FOLDER, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def numbers(value) -> float:
    """Return the sum of all numbers in a decoded message, as the script takes it."""
    if isinstance(value, bool | str) or value is None:
        return 0.0
    if isinstance(value, int | float):
        return float(value) if math.isfinite(value) else 0.0
    if isinstance(value, bytes):
        return float(sum(value))
    parts = value if hasattr(value, "__iter__") else [getattr(value, name) for name in value.__slots__]
    return math.fsum(numbers(part) for part in parts)


@pytest.mark.parametrize("compression", ["zstd", ""])
def test_every_message_of_every_type_is_decoded_to_the_same_numbers(made_up_bag, compression):
    policy = BagPolicy(ChunkPolicy(size=20_000, compression=compression), max_file_span=4_000_000_000)
    bag = Bag(made_up_bag(run=MadeUpRun(duration=10.0), policy=policy))
    found = decode(bag.files)
    assert found["messages"] == {name: topic.message_count for name, topic in bag.topics.items()}
    assert found["types"] == {name: topic.type for name, topic in bag.topics.items()}
    sums: dict[str, float] = {}
    for message, content in bag.decoded():
        sums[message.topic] = sums.get(message.topic, 0.0) + numbers(content)
    assert set(sums) == set(found["sums"])
    for topic, total in sums.items():
        assert found["sums"][topic] == pytest.approx(total, rel=1e-6, abs=1e-3), topic
