"""The clock of this host: whether somebody keeps it right."""

from station.doctor.finding import Finding, judged
from station.doctor.host import as_root
from station.host_clock import ClockState as ClockState
from station.host_clock import clock_state as clock_state


def judge_clock(state: ClockState) -> Finding:
    """Judge the clock by which frames and readings are dated."""
    kept = "synchronised" if state.synchronised else "not synchronised"
    seen = f"{kept}, wrong by {state.largest_error_s:.2g} s at most by the kernel's account"
    install, start = as_root("apt-get install chrony"), as_root("systemctl enable --now chrony")
    cure = f"{install} && {start}; chronyc tracking tells after a minute how far it is"
    return judged("clock", seen, good=state.kept, cure=cure)
