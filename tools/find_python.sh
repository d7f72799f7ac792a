#!/bin/sh
# Print a Python that can carry this project, or say on standard error what is missing. Usage: find_python.sh [PYTHON]
# Without an argument the first that fits of python3, python3.14 ... python3.10 is taken.

usable='import ensurepip, sys, venv; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, 14))'

complain() {
    echo "setup: $*" >&2
    exit 1
}

[ "$(uname -s)-$(uname -m)" = Linux-x86_64 ] || complain "ROS 2 comes as wheels for Linux on x86_64 only, this is" \
    "$(uname -s) on $(uname -m); install ROS 2 and build with colcon (see README.md)"

compiler=${CXX:-c++}
command -v "${compiler%% *}" >/dev/null 2>&1 || command -v g++ >/dev/null 2>&1 || command -v clang++ >/dev/null 2>&1 ||
    complain "no C++ compiler found (tried $compiler, g++, clang++); install one, on Debian or Ubuntu: apt install g++"

for candidate in ${1:-python3 python3.14 python3.13 python3.12 python3.11 python3.10}; do
    if "$candidate" -c "$usable" >/dev/null 2>&1; then
        command -v "$candidate"
        exit 0
    fi
    version=$("$candidate" -c 'import sys; print("%d.%d.%d" % sys.version_info[:3])' 2>/dev/null) &&
        seen="${seen:+$seen, }$candidate is $version" || missing="${missing:+$missing, }$candidate"
done

complain "no usable Python: it must be 3.10 to 3.14 with the venv and ensurepip modules (${seen:-none found}${missing:+; not here: $missing});" \
    "on Debian or Ubuntu: apt install python3-venv, or name one: make ${MAKECMDGOALS:-run} PYTHON=/path/to/python3.12"
