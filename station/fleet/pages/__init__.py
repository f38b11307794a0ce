"""The fleet's view as a folder of pages: files that need no server, no script and no network."""

from station.fleet.pages.building import PagesWritten, note_unreached, write_pages

__all__ = ["PagesWritten", "note_unreached", "write_pages"]
