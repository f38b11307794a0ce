"""The steps of the fleet's schema, one a file, oldest first by name."""
