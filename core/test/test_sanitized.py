"""The core under the address and undefined-behaviour sanitizers: its own tests, and faults in a loop."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "core" / "heave_core" / "src"

FAULTY_LOOP = """
from heave_bringup import ClosedLoop, load_scenario, loop_parameters
for scenario, duration in (("b8_faults", 120), ("b3_deep_900", 10)):
    parameters = loop_parameters(load_scenario(scenario, settings=[f"all.duration={duration}"]))
    loop = ClosedLoop(parameters, has_adviser=False)
    loop.run()
"""
"""Sensors and winch that fail, and a deep load."""


def runtime(name):
    """Return the file of a sanitizer's library; None: it is not there."""
    if shutil.which("g++") is None:
        return None
    found = subprocess.run(
        ["g++", f"-print-file-name={name}"], capture_output=True, text=True, check=True
    ).stdout.strip()
    return found if Path(found).is_absolute() else None


@pytest.fixture(scope="module")
def sanitized(tmp_path_factory):
    """Return the environment in which the core is the sanitized one."""
    libraries = [runtime(name) for name in ("libasan.so", "libubsan.so")]
    if None in libraries:
        pytest.skip("needs g++ with libasan and libubsan")
    prefix = tmp_path_factory.mktemp("sanitized")
    (prefix / "lib").mkdir()
    environment = os.environ | {"PYTHONPATH": str(ROOT / "core"), "PYTHONDONTWRITEBYTECODE": "1"}
    header = subprocess.run(
        [sys.executable, "-m", "heave_core.layout"], env=environment, capture_output=True, check=True, cwd=ROOT
    )
    (prefix / "layout.h").write_bytes(header.stdout)
    flags = ["-std=c++17", "-shared", "-fPIC", "-O1", "-g", "-ffp-contract=off", "-fno-exceptions", "-fno-rtti"]
    checks = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", f"-I{prefix}", f"-I{SOURCES}"]
    sources = map(str, sorted(SOURCES.glob("*.cpp")))
    subprocess.run(["g++", *flags, *checks, *sources, "-o", str(prefix / "lib" / "libheave_core.so")], check=True)
    # Python itself leaks at its end, and numba maps what it compiles
    options = {
        "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1",
        "LD_PRELOAD": ":".join(map(str, libraries)),
    }
    return os.environ | options | {"AMENT_PREFIX_PATH": str(prefix), "OMP_NUM_THREADS": "1"}


OWN = sorted(path.name for path in Path(__file__).parent.glob("test_*.py") if path.name != Path(__file__).name)


@pytest.mark.parametrize("what", ["tests", "faults"])
def test_nothing_is_read_or_written_out_of_bounds_and_nothing_is_undefined(sanitized, what):
    tests = [str(Path("core") / "test" / name) for name in OWN]
    quick = ["-m", "not slow and not long", "-k", "not allocates and not asks_the_system", "-p", "no:cacheprovider"]
    commands = {"tests": ["-m", "pytest", "-q", "-x", "-n0", *quick, *tests], "faults": ["-c", FAULTY_LOOP]}
    done = subprocess.run(
        [sys.executable, *commands[what]], env=sanitized, cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, (done.stdout + done.stderr)[-4000:]
