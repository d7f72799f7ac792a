"""Commands about scenarios."""
