"""A device that is live: from samples to readings of the suite, watched and counted."""
