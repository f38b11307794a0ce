"""The history of the fleet's schema."""
