#!/bin/sh
# Write the exact versions of an environment, and of what builds its messages, as constraints: names and versions, no
# addresses. Usage: constraints.sh FOLDER_OF_ENVIRONMENT > constraints/python3.11.txt
set -eu
python=$1/bin/python
versions() { grep -E '^[A-Za-z0-9._-]+==[A-Za-z0-9.!+_-]+$' | grep -viE '^heave' || true; }
installed=$(mktemp)
trap 'rm -f "$installed"' EXIT
"$1/bin/uv" pip freeze --quiet --python "$python" --exclude-editable | versions > "$installed"
"$python" - <<'PYTHON' | "$1/bin/uv" pip compile --quiet --no-header --no-annotate --python "$python" --constraint "$installed" - |
import sys
try:
    import tomllib
except ImportError:
    import tomli as tomllib
with open("pyproject.toml", "rb") as file:
    print("\n".join(tomllib.load(file)["build-system"]["requires"]))
PYTHON
    versions | cat "$installed" - | LC_ALL=C sort -u | {
    echo "# Exact versions that the tests passed with: $("$python" --version), $(uname -s) $(uname -m). Made by: make constraints"
    cat
}
