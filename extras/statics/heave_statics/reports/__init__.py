"""Reports on a cable at rest."""
