"""The promise "never worse than off" as a distribution: draws that nobody tuned to, run, judged and counted."""
