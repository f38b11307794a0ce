"""How good a calibration is, told by things whose size is known and by calibrating again."""
