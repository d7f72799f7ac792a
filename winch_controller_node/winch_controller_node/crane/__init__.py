"""A crane that moves: its pose as read, checked, and the MRU's motion carried to where the boom tip is."""
