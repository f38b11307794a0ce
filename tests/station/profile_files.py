"""Profile files of wheels that are exactly known."""

import numpy as np

from measure import Profile, format_miniprof, reference_profile

S1002 = reference_profile("S1002")


def profile(*, worn_mm=0.0, from_d_mm=-1.0, to_d_mm=999.0, step_mm=0.3, back_face_mm=18.0):
    """Return S1002 with a tread that lies lower by so much, or a part of it."""
    d, h = (S1002.points(step_mm, back_face_mm=back_face_mm) + [70.0, 0.0]).T
    # From the throat on, so smoothly that no gauge sees an edge.
    h = h - worn_mm * np.clip((d - 40.0) / 20.0, 0.0, 1.0)
    keep = (d >= from_d_mm) & (d <= to_d_mm)
    return Profile(d[keep], h[keep], np.zeros(keep.sum()))


def miniprof_file(path, header=None, **shape):
    """Write a MiniProf file and return its path."""
    path.write_text(format_miniprof(profile(**shape), header), encoding="ascii")
    return path
