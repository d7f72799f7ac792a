"""A crane that moves, in front of the controller: its pose, checked, and the MRU of the boom tip."""
