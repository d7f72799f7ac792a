"""Run many and judge: campaigns, operability, sizing, worst case, lifts, acceptance, what would have been."""
