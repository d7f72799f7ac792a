"""Sources of the vessel's motion: sums of components, filtered noise, a sine, recordings; and what lies over them."""
