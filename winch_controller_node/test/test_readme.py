"""The README's example runs and prints what it says."""

import re
from pathlib import Path

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")


def test_the_example_runs(capsys):
    example = re.search(r"```python\n(.*?)```", README, flags=re.DOTALL)
    assert example is not None
    exec(compile(example.group(1), "README.md", "exec"), {})
    assert "standby" in capsys.readouterr().out


def test_every_module_that_the_readme_names_exists():
    package = Path(__file__).parents[1] / "winch_controller_node"
    rows = re.findall(r"^\| (`[a-z_`, ]+) \|", README, flags=re.MULTILINE)
    names = {name for row in rows for name in re.findall(r"`([a-z_]+)`", row)} - {
        "off",
        "feedforward",
        "lqr",
        "lqg",
        "mpc",
    }
    missing = [name for name in sorted(names) if not (package / f"{name}.py").exists()]
    assert missing == []
