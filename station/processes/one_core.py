"""A process that works on pictures with one core."""

import ctypes

import cv2

_M_TRIM_THRESHOLD, _M_TOP_PAD, _M_MMAP_THRESHOLD = -1, -2, -3  # <malloc.h>
_KEPT_BYTES = 32 << 20  # the largest M_MMAP_THRESHOLD that glibc takes on 64 bits


def use_one_core() -> None:
    """Let this process work on one core, and keep the memory that it frees.

    Others have the other cores. Arrays of a picture's size come and go many times a picture; giving
    their pages back each time, and having them zeroed again, takes a tenth of locating a stripe.
    """
    cv2.setNumThreads(1)
    keep_freed_memory()


def keep_freed_memory() -> None:
    """Keep up to 32 MiB of freed memory; a C library without `mallopt` is left as it is."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        for option in (_M_MMAP_THRESHOLD, _M_TRIM_THRESHOLD, _M_TOP_PAD):
            mallopt(option, _KEPT_BYTES)
