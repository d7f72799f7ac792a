"""What killed processes leave in shared memory is removed; what belongs to a living process never is."""

import fcntl
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from domain_coordinator import domain_id
from heave_node.ros.transport.shared_memory import remove_dead_segments

SEGMENT = "fastdds_0123456789abcdef"
PORT = "fastdds_port7411"


def make(folder: Path, *names: str, age: float = 100.0) -> None:
    for name in names:
        (folder / name).write_bytes(b"")
        os.utime(folder / name, (time.time() - age,) * 2)


def names_in(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("files", [(SEGMENT, f"{SEGMENT}_el"), (f"{SEGMENT}_sl",)])
def test_what_nobody_holds_is_removed_and_named(tmp_path, files):
    make(tmp_path, *files)
    assert remove_dead_segments(tmp_path) == sorted(files)
    assert names_in(tmp_path) == []


@pytest.mark.parametrize("lock", [fcntl.LOCK_EX, fcntl.LOCK_SH])
def test_what_a_living_process_holds_is_left(tmp_path, lock):
    make(tmp_path, SEGMENT, f"{SEGMENT}_el")
    with (tmp_path / f"{SEGMENT}_el").open() as held:
        fcntl.flock(held, lock)
        assert remove_dead_segments(tmp_path) == []
    assert len(names_in(tmp_path)) == 2


@pytest.mark.parametrize(
    ("files", "age"),
    [
        ((PORT, f"{PORT}_el", f"{PORT}_sl", f"sem.{PORT}_mutex"), 100.0),  # may be opened and not yet locked
        ((SEGMENT, f"{SEGMENT}_el"), 0.0),  # may be half made
        ((SEGMENT, "fastdds_notours_el", "other_0123456789abcdef_el", f"{SEGMENT}_el.txt"), 100.0),
    ],
)
def test_ports_what_has_just_been_made_and_other_names_are_left(tmp_path, files, age):
    make(tmp_path, *files, age=age)
    assert remove_dead_segments(tmp_path) == []
    assert names_in(tmp_path) == sorted(files)


def test_what_another_user_left_is_left_to_him(tmp_path, monkeypatch):
    make(tmp_path, SEGMENT, f"{SEGMENT}_el")
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    assert remove_dead_segments(tmp_path) == []


def test_a_lock_file_that_is_a_link_is_not_followed_nor_is_a_folder_missed(tmp_path):
    make(tmp_path, "precious")
    (tmp_path / f"{SEGMENT}_el").symlink_to(tmp_path / "precious")
    assert remove_dead_segments(tmp_path, minimum_age=0.0) == []
    assert (tmp_path / "precious").exists()
    assert remove_dead_segments(tmp_path / "absent") == []


def test_a_name_that_was_given_to_a_new_segment_meanwhile_is_left(tmp_path, monkeypatch):
    """Another process found it dead as well, and one made it again between this one's look and its lock."""
    make(tmp_path, SEGMENT, f"{SEGMENT}_el")
    take = fcntl.flock

    def made_anew(descriptor: int, operation: int) -> None:
        (tmp_path / f"{SEGMENT}_el").unlink()
        make(tmp_path, f"{SEGMENT}_el", age=0.0)
        take(descriptor, operation)

    monkeypatch.setattr(fcntl, "flock", made_anew)
    assert remove_dead_segments(tmp_path) == []
    assert names_in(tmp_path) == [SEGMENT, f"{SEGMENT}_el"]


NODE = """
import sys
from heave_node.ros.transport.environment import prepare_environment
prepare_environment()
import rclpy
rclpy.init()
node = rclpy.create_node("short_lived")
print("up", flush=True)
sys.stdin.read()
"""


def segments() -> set[str]:
    return {path.name for path in Path("/dev/shm").glob("fastdds_????????????????*")}


@pytest.mark.skipif(not Path("/dev/shm").is_dir(), reason="no /dev/shm")
def test_segments_of_a_killed_node_go_and_those_of_living_and_stopped_ones_stay():
    """With what Fast DDS itself makes: the names and locks are its own, not this test's."""
    with domain_id() as domain:
        owned = {}
        for fate in ("killed", "living", "stopped"):
            process = subprocess.Popen(
                [sys.executable, "-c", NODE],
                env={**os.environ, "ROS_DOMAIN_ID": str(domain)},
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
            assert process.stdout.readline() == "up\n"
            owned[fate] = (process, segments_of(process.pid))
        try:
            owned["killed"][0].kill()
            owned["killed"][0].wait()
            owned["stopped"][0].send_signal(signal.SIGSTOP)
            assert all(names for _, names in owned.values())
            deadline = time.monotonic() + 10.0
            # another command that starts in this moment tries the locks too; whoever comes second leaves them alone
            while owned["killed"][1] & segments() and time.monotonic() < deadline:
                remove_dead_segments(minimum_age=0.5)
                time.sleep(0.1)
            assert not owned["killed"][1] & segments()
            assert (owned["living"][1] | owned["stopped"][1]) <= segments()
        finally:
            for process, _ in owned.values():
                process.kill()
                process.communicate()


def segments_of(pid: int) -> set[str]:
    """Return the segments whose locks a process holds open."""
    links = []
    for entry in Path(f"/proc/{pid}/fd").iterdir():
        with suppress(FileNotFoundError):  # closed meanwhile: the middleware has threads of its own
            links.append(str(entry.readlink()))
    locks = {Path(link).name for link in links if link.startswith("/dev/shm/fastdds_") and "port" not in link}
    return locks | {lock.removesuffix("_el") for lock in locks}
