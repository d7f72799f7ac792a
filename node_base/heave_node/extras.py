"""Packages that one command or one kind of file needs, and nothing else: the extras of `pyproject.toml`."""


def how_to_install(extra: str) -> str:
    """Return the command, given in the folder of the suite, that installs the packages of an `extra`.

    >>> how_to_install("dask")
    'in the folder of the suite: .venv/bin/uv pip install -r pyproject.toml --extra dask'
    """
    return f"in the folder of the suite: .venv/bin/uv pip install -r pyproject.toml --extra {extra}"
