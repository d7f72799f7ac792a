"""Layouts by the definition that a bag carries, which may be anything: what is wrong with it is a fault of the bag."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from heave_node.cdr.layout import LayoutError, MessageLayouts

from heave_bags.errors import BagError


@contextmanager
def as_bag_error() -> Iterator[None]:
    """Turn a LayoutError into a BagError."""
    try:
        yield
    except LayoutError as error:
        raise BagError(str(error)) from error


def layouts_in_bag(name: str, text: str) -> MessageLayouts:
    """Return the layouts of the type `name` by its `ros2msg` schema `text`.

    Raises BagError for a schema that cannot be.
    """
    with as_bag_error():
        return MessageLayouts(name, text)
