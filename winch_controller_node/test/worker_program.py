"""What a worker of the tests answers with: a module of its own, since the worker's process imports it by name."""

import os


def make_answer(tick_period):
    """Return what answers each question with itself behind the id of the process and the tick period."""

    def answer(data):
        if data == b"fail":
            raise ValueError("no\nanswer")
        return f"{os.getpid()} {tick_period} ".encode() + data

    return answer


def make_none(tick_period):
    """Make nothing that could answer."""
    raise ValueError(f"no adviser for {tick_period} s")
