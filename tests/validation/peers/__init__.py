"""The plant beside its peers: reference systems, driven runs, MoorDyn, and the benchmark."""
