"""Profiles from elsewhere: read, gauged, written, and made a reference."""
