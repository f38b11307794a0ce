"""From a stripe on a wheel to gauge readings, with uncertainty.  Pure mathematics, lengths in mm."""
