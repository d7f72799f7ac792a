"""What is read from files that anyone may have written, within bounds."""
