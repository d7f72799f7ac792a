"""The controller's tick in C++ (read `src/tick.cpp` first; `page.py` lists the files), its layout and its library."""
