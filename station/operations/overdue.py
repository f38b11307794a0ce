"""When a pass or session ends by itself, and what it says of that."""

from datetime import datetime, timedelta

from station.operations.hearing import Heard
from station.settings import ControllerSettings


def why_pass_overdue(heard: Heard, limits: ControllerSettings, now: datetime) -> str | None:
    """Return why a pass is ended without its controller, in a sentence; None where it goes on."""
    if heard.silent_s >= limits.quiet_s:
        return (
            f"no finish came, and no frame for {limits.quiet_s:g} s (quiet_s); {_seen(heard, now)}"
        )
    if heard.age_s >= limits.pass_longest_s:
        longest = f"{limits.pass_longest_s:g} s (pass_longest_s)"
        return f"no finish came within {longest} of its arming; {_seen(heard, now)}"
    return None


def why_session_overdue(heard: Heard, limits: ControllerSettings, now: datetime) -> str | None:
    """Return why a calibration session is ended by itself, in a sentence; None where it goes on."""
    if heard.silent_s < limits.session_quiet_s:
        return None
    quiet = f"{limits.session_quiet_s:g} s (session_quiet_s)"
    return f"no finish came, and no picture for {quiet}; {_seen(heard, now)}"


def _seen(heard: Heard, now: datetime) -> str:
    at = (now - timedelta(seconds=heard.silent_s)).isoformat(timespec="seconds")
    seen = f"the last frame came at {at}" if heard.any_frame else f"none had come since {at}"
    deaf = f"; no longer recorded by {', '.join(heard.deaf)}" if heard.deaf else ""
    return seen + deaf
