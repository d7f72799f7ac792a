"""What can go wrong with bags: one tree of exceptions, each with a message of one line."""


def one_line(text: str) -> str:
    """Return a text as one line that any terminal may show; a bag may bring names with anything in them."""
    return "".join(letter if letter.isprintable() else letter.encode("unicode_escape").decode() for letter in text)


class BagError(Exception):
    """A bag that cannot be written, read or used as asked; the message says which bag, what, and what to do."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class NoBagError(BagError):
    """There is no bag where one should be read: nothing, or a file of another kind."""


class StorageError(BagError):
    """A write to the disk failed: it is full, too slow, or gone."""
