"""The controller's tick in C++: its layout, and the library by ctypes."""

from heave_core.library import Envelope, LibraryError

__all__ = ["Envelope", "LibraryError"]
