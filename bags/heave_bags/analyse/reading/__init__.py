"""What a bag gives before a run is made of it: columns of topics, the scenario that it carries, the depth."""
