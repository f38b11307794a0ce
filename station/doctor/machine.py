"""Processors, memory and limits of this host."""

import os
import resource
from collections.abc import Sequence

from station.doctor.demand import Stream
from station.doctor.finding import Finding, judged, megabytes
from station.doctor.host import Host, as_root, to_keep

_CORES_PER_CAMERA = 0.4
_SLOW_GOVERNORS = frozenset({"powersave", "conservative"})
_ADAPTING_DRIVERS = frozenset({"intel_pstate", "amd-pstate-epp"})
"""Their `powersave` raises the clock with the load, within a millisecond."""
_CPUFREQ = "sys/devices/system/cpu/cpu0/cpufreq"
_OTHERS_BYTES = 1_500_000_000
"""API, worker and a calibration, which took 0.9 GB at the most."""
_OPEN_FILES = 1024


def judge_processors(cores: int, streams: Sequence[Stream]) -> Finding:
    """Judge the cores: receiver and recorder of a camera get 0.4 of one, everything else one."""
    needed = 1.0 + _CORES_PER_CAMERA * len(streams)
    seen = f"{cores} cores; {needed:g} for {len(streams)} camera(s) and the rest"
    cure = (
        f"give the service {-int(-needed // 1)} cores or more: AllowedCPUs= of its unit, or the "
        "machine's"
    )
    return judged("processors", seen, good=cores >= needed, cure=cure)


def judge_governor(host: Host) -> Finding:
    """Judge how processors change their clock: a slow one wakes late."""
    governor = host.text(f"{_CPUFREQ}/scaling_governor")
    driver = host.text(f"{_CPUFREQ}/scaling_driver")
    slow = governor in _SLOW_GOVERNORS and driver not in _ADAPTING_DRIVERS
    seen = f"governor {governor} ({driver})" if governor else "not governed by this system"
    cure = (
        f"echo performance | {as_root('tee')} /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor"
        ", and the same in a unit for the next start"
    )
    return judged("governor", seen, good=not slow, cure=cure)


def judge_memory(host: Host, streams: Sequence[Stream]) -> Finding:
    """Judge the memory: the rings take theirs at once, and a host that swaps loses frames."""
    available = _available_bytes(host)
    rings = sum(stream.ring_bytes for stream in streams)
    needed = rings + _OTHERS_BYTES
    seen = (
        f"{megabytes(available)} to be had, {megabytes(needed)} needed ({megabytes(rings)} rings)"
    )
    slots = ", ".join(f"{stream.sensor} {stream.ring_slots}" for stream in streams)
    cure = f"lower ring_slots in the settings ({slots}), or raise MemoryMax= of the unit"
    return judged("memory", seen, good=available >= needed, cure=cure)


def judge_shared_memory(host: Host) -> Finding:
    """Try what the ring is made of: a memfd, which a hardened kernel may forbid."""
    try:
        os.close(os.memfd_create("trial"))
    except OSError as error:
        setting = host.sysctl("vm.memfd_noexec")
        seen = f"memfd_create is refused ({error.strerror}; vm.memfd_noexec {setting})"
        return Finding("shared memory", seen, to_keep("vm.memfd_noexec", 1))
    return Finding("shared memory", "memfd_create works")


def judge_limits(open_files: int, file_bytes: int) -> Finding:
    """Judge the limits of the process: no more files, no recording."""
    largest = "any size" if file_bytes == resource.RLIM_INFINITY else megabytes(file_bytes)
    seen = f"{open_files} open files, files of {largest}"
    good = open_files >= _OPEN_FILES and file_bytes == resource.RLIM_INFINITY
    cure = "ulimit -n 4096 -f unlimited; for the service LimitNOFILE=4096 and no LimitFSIZE="
    return judged("limits", seen, good=good, cure=cure)


def own_cores() -> int:
    """Return how many cores this process may run on."""
    return len(os.sched_getaffinity(0))


def own_limits() -> tuple[int, int]:
    """Return how many files this process may open, and how large a file may become."""
    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    size, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
    return files, size


def _available_bytes(host: Host) -> int:
    """Memory to be had, within the bound of the service's control group."""
    free = int((host.field("proc/meminfo", "MemAvailable") or "0").split()[0]) * 1024
    bound = host.number("sys/fs/cgroup/memory.max")
    used = host.number("sys/fs/cgroup/memory.current") or 0
    return free if bound is None else min(free, bound - used)
