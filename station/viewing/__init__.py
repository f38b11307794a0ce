"""Pictures for people, and what was found on them, made by a process of its own.

Decoding, drawing and looking for stripes in the process that answers calls would keep its callers
waiting, so none of that is done there.  That process is started when somebody looks, goes behind
everything that measures or records, and ends when nobody has looked for a minute.
"""

from station.viewing.client import Viewer, ViewerLost
from station.viewing.moments import moment
from station.viewing.orders import Form, SeenFrame, SharedPicture, View, ViewOrder

__all__ = [
    "Form",
    "SeenFrame",
    "SharedPicture",
    "View",
    "ViewOrder",
    "Viewer",
    "ViewerLost",
    "moment",
]
