import os
from types import SimpleNamespace

import pytest
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
