"""Where to show the target next: what the pictures so far leave open of the sensor."""
