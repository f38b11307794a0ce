"""Pictures on their way from the camera to the disk, in memory that two processes share.

The memory has no name in the system: it lives as long as one of the two processes does and cannot
be left behind by a killed one.
"""

import ctypes
import mmap
import os

_PAGE = mmap.PAGESIZE


class Ring:
    """Slots of equal size, one picture each."""

    def __init__(self, descriptor: int, slot_bytes: int) -> None:
        self.descriptor = descriptor
        self.slot_bytes = slot_bytes
        self._memory = mmap.mmap(descriptor, 0)
        self._view = memoryview(self._memory)
        self.slots = len(self._memory) // slot_bytes

    @classmethod
    def create(cls, slots: int, picture_bytes: int) -> "Ring":
        """Make a ring and touch all of it, so that no frame waits for the system to find memory."""
        slot_bytes = -(-picture_bytes // _PAGE) * _PAGE
        descriptor = os.memfd_create("frames")
        os.ftruncate(descriptor, slots * slot_bytes)
        ring = cls(descriptor, slot_bytes)
        ring._view[::_PAGE] = bytes(slots * slot_bytes // _PAGE)
        return ring

    def address(self, slot: int) -> int:
        """Return where a slot begins in this process's memory."""
        start = ctypes.addressof(ctypes.c_char.from_buffer(self._memory))
        return start + slot * self.slot_bytes

    def picture(self, slot: int, size: int) -> memoryview:
        """Return the bytes of the picture in a slot."""
        start = slot * self.slot_bytes
        return self._view[start : start + size]

    def close(self) -> None:
        """Give the memory back; nothing may use it any more."""
        self._view.release()
        self._memory.close()
        os.close(self.descriptor)
