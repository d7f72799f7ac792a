"""Jumps that one sensor alone can make: what finds them and takes them off its readings."""
