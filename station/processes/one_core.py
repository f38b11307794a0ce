"""A process that works on pictures with one core."""

import ctypes
import os

import cv2
from threadpoolctl import threadpool_limits

_BLAS_THREADS = "OPENBLAS_NUM_THREADS"
_M_TRIM_THRESHOLD, _M_TOP_PAD, _M_MMAP_THRESHOLD = -1, -2, -3  # <malloc.h>
_KEPT_BYTES = 32 << 20  # the largest M_MMAP_THRESHOLD that glibc takes on 64 bits


def use_one_core() -> None:
    """Let this process work on one core, and keep the memory that it frees.

    Others have the other cores. Arrays of a picture's size come and go many times a picture; giving
    their pages back each time, and having them zeroed again, takes a tenth of locating a stripe.
    """
    cv2.setNumThreads(1)
    use_one_blas_thread()
    keep_freed_memory()


def use_one_blas_thread() -> None:
    """Solve with one thread; where the user's environment says how many, that counts.

    OpenBLAS takes a thread for each core, and those of several processes wait for each other: on a
    busy machine that took twice the time of a rig's solution.
    """
    if _BLAS_THREADS in os.environ:
        return
    threadpool_limits(1, user_api="blas")  # of what is loaded: numpy's
    os.environ[_BLAS_THREADS] = "1"  # of what is loaded later: scipy's, and in processes begun here


def keep_freed_memory() -> None:
    """Keep up to 32 MiB of freed memory; a C library without `mallopt` is left as it is."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        for option in (_M_MMAP_THRESHOLD, _M_TRIM_THRESHOLD, _M_TOP_PAD):
            mallopt(option, _KEPT_BYTES)
