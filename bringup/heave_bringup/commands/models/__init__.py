"""Commands that compute with the models behind a scenario, without a run."""
