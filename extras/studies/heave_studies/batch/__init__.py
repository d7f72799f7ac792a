"""Many cases at once, screened by the plant's own kernels under a fixed law; what that does not cover runs in full."""

import cable_sim_node.line
import cable_sim_node.winch.drive
from heave_node.numerics.compiled import drop_stale_kernels

drop_stale_kernels(__file__, cable_sim_node.line.__file__, cable_sim_node.winch.drive.__file__)
