"""The operator's page in a browser: what it shows, who is in command, and the link to the run behind it.

The page reads and requests; no tick of the run waits for it, for its viewers or for their network.
"""
