"""What a step of a procedure is run against: a winch by itself, the whole loop, or a record of somebody else."""
