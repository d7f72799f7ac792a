"""Who can reach a node and whom it listens to: environment, quality of service, identity, strangers."""
