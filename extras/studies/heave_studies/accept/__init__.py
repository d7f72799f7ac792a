"""Acceptance tests: procedures of steps, each judged by criteria, against virtual or real parts."""
