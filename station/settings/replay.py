"""The `[replay]` of the settings file: who measures recordings once more."""

import re

from pydantic import field_validator

from station.settings.section import Section

_ADDRESS = re.compile(r"(tcp|tls)://[^/\s]+:[0-9]{1,5}")


class ReplaySettings(Section):
    """Measuring recordings once more."""

    cluster: str | None = None
    """Scheduler of a Dask cluster of the site, as tcp://HOST:8786 or tls://HOST:8786, whose workers
    have this version of the software and read the recordings at the same paths as the station.
    Absent, or not in reach: the cores of this machine."""

    @field_validator("cluster")
    @classmethod
    def _is_an_address(cls, address: str | None) -> str | None:
        if address is not None and not _ADDRESS.fullmatch(address):
            raise ValueError(
                f"cluster {address!r}: not the address of a Dask scheduler; give what "
                "`dask scheduler` prints, as tcp://HOST:8786 or tls://HOST:8786"
            )
        return address
