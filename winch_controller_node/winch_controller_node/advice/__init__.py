"""How core and adviser talk: observations and beliefs as messages, and the bookkeeping of who answered when."""
