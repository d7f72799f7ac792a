"""Worker processes of the studies."""
