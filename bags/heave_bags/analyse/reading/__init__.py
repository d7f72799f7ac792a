"""What a bag gives to build a run from: columns of topics, the scenario that it carries, the programme of depth."""
