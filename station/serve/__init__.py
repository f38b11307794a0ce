"""Running the station: the processes, their supervisor, their logs."""

from station.logs import log_as
from station.serve.certificate import ensure_tls_usable
from station.serve.supervisor import supervise

__all__ = ["ensure_tls_usable", "log_as", "supervise"]
