"""What processes of the station have in common: their beginning, their end, their core."""
