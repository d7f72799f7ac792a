"""Playing bags: replay, a bag in the place of a node, a ship's records as a sea."""
