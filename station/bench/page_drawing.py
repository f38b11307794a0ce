"""A profile of as many points as is asked, for a browser to draw."""

import json

import numpy as np

from measure import reference_profile
from station.documents import ProfileDocument, WheelDocument
from station.page import profile_drawing

_REFERENCE = "S1002"


def drawing_of(wheel: WheelDocument, points: int) -> str:
    """Return what the page of a wheel fetches, its profile sampled anew; as JSON.

    Raises
    ------
    NotFound
        If it has no profile.
    """
    given = wheel.profile
    finer = wheel if given is None else wheel.model_copy(update={"profile": _finer(given, points)})
    return json.dumps(profile_drawing(1, finer, reference_profile(_REFERENCE), _REFERENCE))


def _finer(profile: ProfileDocument, points: int) -> ProfileDocument:
    """Sample along the line, which may run back on itself: by place in it, not by distance."""
    places = np.linspace(0.0, len(profile.d_mm) - 1.0, points)
    before = np.arange(len(profile.d_mm))

    def sampled(values: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(np.interp(places, before, values).tolist())

    nearest = np.rint(places).astype(int)
    seen_by = profile.seen_by
    return ProfileDocument(
        d_mm=sampled(profile.d_mm),
        h_mm=sampled(profile.h_mm),
        sigma_mm=sampled(profile.sigma_mm),
        sensors=profile.sensors,
        seen_by=None if seen_by is None else tuple(seen_by[place] for place in nearest),
    )
