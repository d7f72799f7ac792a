"""Runs a generator of ROS messages: `python parse_once.py FOLDER SCRIPT ...`. What one has parsed the others take.

Each of six generators parses all interfaces again, which takes 2.7 s of CPU. The first that comes to one of them
keeps it, parsed, in FOLDER under the digest of its text; others that come to it meanwhile wait.
"""

import fcntl
import hashlib
import os
import pickle
import runpy
import sys
from pathlib import Path


def main():
    """Run the script, or what else an interpreter is asked for."""
    folder, arguments = Path(sys.argv[1]), sys.argv[2:]
    if not arguments or arguments[0].startswith("-"):
        os.execv(sys.executable, [sys.executable, *arguments])
    from rosidl_parser import parser  # noqa: PLC0415 - not needed for what else is run

    parse = parser.parse_idl_string

    def parse_once(text, png_file=None):
        with (folder / hashlib.sha256(text.encode()).hexdigest()).open("ab+") as kept:
            fcntl.flock(kept, fcntl.LOCK_EX)
            kept.seek(0)
            known = kept.read()
            if known:
                return pickle.loads(known)
            content = parse(text, png_file)
            kept.write(pickle.dumps(content))
            return content

    parser.parse_idl_string = parse_once
    sys.argv, sys.path[0] = arguments, str(Path(arguments[0]).parent)
    runpy.run_path(arguments[0], run_name="__main__")


main()
