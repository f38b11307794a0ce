"""The `[fleet]` of the settings file: the database that many stations send what they know to."""

from typing import Annotated

from pydantic import Field, StringConstraints

from station.settings.section import Section


class FleetSettings(Section):
    """The fleet this station is part of."""

    url: str | None = Field(default=None, repr=False)
    """Database of the fleet, as postgresql://USER:PASSWORD@HOST/DATABASE.  A password is better
    given with the whole URL as STATION_FLEET_URL in the environment, or as the credential
    `fleet_url` of the service."""
    station: Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9._-]{1,64}$")] | None = None
    """What the fleet knows this station by, for ever; absent: its `name`.  No two may share it."""
    every_s: float = Field(default=10.0, ge=0.1, le=3600.0)
    """How often what is new is sent, s."""
    longest_pause_s: float = Field(default=600.0, ge=1.0, le=86_400.0)
    """How long the station waits at most before it tries again where the fleet is away, s."""
    profiles: bool = False
    """Whether the profiles of the wheels are sent too: 40 kB each in place of 2."""
    alarm_after_days: float = Field(default=3.0, gt=0.0)
    """An alarm is raised where the fleet was not reached for so many days."""
