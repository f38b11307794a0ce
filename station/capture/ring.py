"""Pictures on their way from the camera to the disk, in memory that two processes share.

The memory has no name in the system: it lives as long as one of the two processes does and cannot
be left behind by a killed one.
"""

import ctypes
import mmap
import os

_PAGE = mmap.PAGESIZE


def _slot_bytes(picture_bytes: int) -> int:
    """Slots begin on pages."""
    return -(-picture_bytes // _PAGE) * _PAGE


class Ring:
    """Slots of equal size, one picture each."""

    def __init__(self, descriptor: int, picture_bytes: int) -> None:
        self.descriptor = descriptor
        self.picture_bytes = picture_bytes
        self._slot_bytes = _slot_bytes(picture_bytes)
        self._memory = mmap.mmap(descriptor, 0)
        self._view = memoryview(self._memory)
        self.slots = len(self._memory) // self._slot_bytes

    @classmethod
    def create(cls, slots: int, picture_bytes: int) -> "Ring":
        """Make a ring and touch all of it, so that no frame waits for the system to find memory."""
        size = slots * _slot_bytes(picture_bytes)
        descriptor = os.memfd_create("frames")
        os.ftruncate(descriptor, size)
        ring = cls(descriptor, picture_bytes)
        ring._view[::_PAGE] = bytes(size // _PAGE)
        return ring

    def address(self, slot: int) -> int:
        """Return where a slot begins in this process's memory."""
        start = ctypes.addressof(ctypes.c_char.from_buffer(self._memory))
        return start + slot * self._slot_bytes

    def picture(self, slot: int, size: int) -> memoryview:
        """Return the bytes of the picture in a slot."""
        start = slot * self._slot_bytes
        return self._view[start : start + size]

    def close(self) -> None:
        """Give the memory back; nothing may use it any more."""
        self._view.release()
        self._memory.close()
        os.close(self.descriptor)
