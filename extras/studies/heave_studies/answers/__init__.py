"""What is made of the cases of a study: an answer is a module with KEYS, `prepare` and `answer`, found by its name."""
