"""The winch controller: models of the loop, estimation, control laws, design and its report."""
