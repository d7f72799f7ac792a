"""What can go wrong with bags: one tree of exceptions, each with a message of one line."""


class BagError(Exception):
    """A bag that cannot be written, read or used as asked; the message says which bag, what, and what to do."""


class StorageError(BagError):
    """The disk refuses what is to be written: full, too slow, or gone."""
