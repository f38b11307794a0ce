"""Where the reference lies under the points of a stripe: its flange found and laid on."""
