"""Commands that record, play and judge bags."""
