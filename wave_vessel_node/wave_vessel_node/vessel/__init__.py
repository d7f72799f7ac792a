"""The vessel: its course, its response to waves by RAO or as a second-order filter, and the motion of a point of it."""
