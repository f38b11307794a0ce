"""Running the station: the processes, their supervisor, their logs."""

from station.logs import log_as
from station.serve.supervisor import supervise

__all__ = ["log_as", "supervise"]
