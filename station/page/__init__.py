"""The page for people with a browser: five views of the station, without anything from elsewhere.

Each page is a folder with its routes, what it shows (`views.py`), its templates, scripts and style;
what all pages share is here.  Every text is in `texts/en`, one file a page.
"""

from station.page.app import add_pages
from station.page.passes.profile_drawing import profile_drawing

__all__ = ["add_pages", "profile_drawing"]
