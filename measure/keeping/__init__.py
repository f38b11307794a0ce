"""Which points of a stripe are the wheel, and how they scatter."""
