"""The controller's tick in C++: its layout, and the library by ctypes."""
