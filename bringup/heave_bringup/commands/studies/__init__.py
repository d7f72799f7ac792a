"""Commands that run many cases, or measure."""
