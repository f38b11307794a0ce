"""How frame ids follow one another: GigE Vision's block ids."""

_LARGEST_16_BIT = 65535


def ids_skipped(previous: int, current: int) -> int | None:
    """Return how many ids lie between two frames; None where `current` is not ahead.

    16-bit ids run from 1 to 65535 and begin again at 1; ids beyond that are of cameras with 64-bit
    ids, which never begin again.  Of 16-bit ids one less than half a turn away is ahead: a loss of
    more than 32766 frames in one go is ten minutes at 53 frames/s, and other guards see it sooner.

    Examples
    --------
    >>> ids_skipped(7, 8), ids_skipped(65534, 2), ids_skipped(65535, 65536)
    (0, 2, 0)
    >>> ids_skipped(8, 8) is None, ids_skipped(8, 7) is None
    (True, True)
    """
    if max(previous, current) > _LARGEST_16_BIT:
        step = current - previous
    else:
        step = (current - previous) % _LARGEST_16_BIT
        if step > _LARGEST_16_BIT // 2:
            return None
    return step - 1 if step > 0 else None


def id_after(frame_id: int, steps: int = 1) -> int:
    """Return the 16-bit id so many frames later.

    Examples
    --------
    >>> id_after(65535), id_after(10, 3)
    (1, 13)
    """
    if frame_id > _LARGEST_16_BIT:
        return frame_id + steps
    return (frame_id - 1 + steps) % _LARGEST_16_BIT + 1
