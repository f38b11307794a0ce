"""From a stripe to a section of the wheel, laid over the reference."""
