import os
import subprocess
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace

import pytest
from heave_node.numerics import compiled
from heave_node.numerics.compiled import drop_stale_kernels, is_compiled, kernel


@pytest.fixture
def folders(tmp_path):
    """Two package folders whose sources are of second 1000 and whose kernels of second 2000."""
    for name in ("caller", "called"):
        cache = tmp_path / name / "__pycache__"
        cache.mkdir(parents=True)
        for file, second in ((tmp_path / name / "__init__.py", 1000), (cache / "kernel.nbi", 2000)):
            file.touch()
            os.utime(file, (second, second))
    return tmp_path


def kernels(folders):
    return sorted(path.parts[-3] for path in folders.glob("*/__pycache__/*.nbi"))


def test_kernels_newer_than_their_sources_stay(folders):
    drop_stale_kernels(str(folders / "caller" / "__init__.py"), str(folders / "called" / "__init__.py"))
    assert kernels(folders) == ["called", "caller"]


def test_an_edit_drops_the_kernels_of_its_own_folder_alone(folders):
    os.utime(folders / "called" / "__init__.py", (3000, 3000))
    drop_stale_kernels(str(folders / "called" / "__init__.py"))
    drop_stale_kernels(str(folders / "caller" / "__init__.py"))
    assert kernels(folders) == ["caller"]


def test_an_edit_drops_the_kernels_of_the_folders_that_call_it(folders):
    os.utime(folders / "called" / "__init__.py", (3000, 3000))
    drop_stale_kernels(str(folders / "caller" / "__init__.py"), str(folders / "called" / "__init__.py"))
    assert kernels(folders) == ["called"]


def test_a_kernel_is_compiled_where_numbas_cache_has_it(tmp_path):
    class Kernel:
        __name__ = "march"
        stats = SimpleNamespace(cache_path=str(tmp_path))

    assert not is_compiled(Kernel())
    (tmp_path / "step.march_on-3.py311.nbi").touch()
    assert not is_compiled(Kernel())
    (tmp_path / "step.march-3.py311.nbi").touch()
    assert is_compiled(Kernel())


def test_numba_says_where_its_cache_is():
    assert isinstance(is_compiled(kernel(lambda x: x)), bool)


READ_ONLY = """
import os, tempfile
really = tempfile.TemporaryFile
def make(dir):
    if str(dir).startswith("{sources}"):
        raise OSError("read-only file system")
    return really(dir=dir)
tempfile.TemporaryFile = make
from numba.core import caching
def refuse(self):
    if not self.get_cache_path().startswith("{tmp}"):
        raise OSError("read-only file system")
    os.makedirs(self.get_cache_path(), exist_ok=True)
caching._CacheLocator.ensure_cache_path = refuse
from heave_node.numerics.compiled import kernel, load
load()
print(os.environ["NUMBA_CACHE_DIR"])
"""


def test_where_neither_sources_nor_home_can_be_written_the_kernels_are_kept_below_the_temporary_folder(tmp_path):
    """As in a container with a read-only root and a service without a home: a folder of this user alone."""
    sources = Path(compiled.__file__).parents[2]
    program = READ_ONLY.format(sources=sources, tmp=tmp_path)
    environment = {**os.environ, "HOME": "/proc/nohome", "TMPDIR": str(tmp_path), "PYTHONPATH": str(sources)}
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        environment.pop(name, None)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    cache = Path(done.stdout.strip())
    assert cache.parent == tmp_path
    assert cache.stat().st_mode & 0o077 == 0
    assert list(cache.rglob("*.nbi")), "and they are there for the next command"


def test_a_cache_of_somebody_else_is_not_used(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    own = compiled.temporary_cache(tmp_path)
    assert compiled.temporary_cache(tmp_path) == own
    own.chmod(0o777)
    assert compiled.temporary_cache(tmp_path) != own
