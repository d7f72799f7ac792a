"""Parameters of the drives, and of what they share: motion, friction, spool."""
