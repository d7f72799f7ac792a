"""The README's example runs and prints what it says."""

import re
from pathlib import Path

from winch_controller_node.laws.registry import LAWS

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")


def test_the_example_runs(capsys):
    example = re.search(r"```python\n(.*?)```", README, flags=re.DOTALL)
    assert example is not None
    exec(compile(example.group(1), "README.md", "exec"), {})
    assert "standby" in capsys.readouterr().out


def test_every_module_that_the_readme_names_exists():
    package = Path(__file__).parents[1] / "winch_controller_node"
    table = README.split("## What is in here")[1].split("## Laws")[0]
    rows = re.findall(r"^\| (`[a-z_`/, ]+) \|", table, flags=re.MULTILINE)
    names = {name for row in rows for name in re.findall(r"`([a-z_/]+)`", row)}
    assert len(names) > 15
    missing = [name for name in sorted(names) if not ((package / f"{name}.py").exists() or (package / name).is_dir())]
    assert missing == []


def test_every_law_is_in_the_table_of_laws():
    table = README.split("## Laws (parameter `law`)")[1]
    assert set(LAWS) <= set(re.findall(r"^\| `([a-z_]+)` \|", table, flags=re.MULTILINE))
