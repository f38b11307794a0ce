"""The schema's steps, one a file, oldest first by name."""
