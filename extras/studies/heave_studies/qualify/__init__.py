"""The evidence for one release as a folder: what the tests compare, how far off it is, and what is not shown."""
