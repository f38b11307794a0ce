"""The settings of the page and API towards the network: who is believed, how much is taken."""

from pathlib import Path
from typing import Self

from pydantic import Field, IPvAnyNetwork, model_validator

from station.settings.section import Section


class TlsSettings(Section):
    """The certificate the page and API show, where no proxy in front does it."""

    certificate: Path
    """Certificate and those it rests on, PEM; relative to the folder of the settings file."""
    key: Path
    """Its private key, PEM, without a password; readable by the station's user alone."""

    def beside(self, folder: Path) -> Self:
        """Return them with relative paths counted from a folder."""
        paths = {"certificate": folder / self.certificate, "key": folder / self.key}
        return self.model_copy(update={name: path.resolve() for name, path in paths.items()})


class WebSettings(Section):
    """What the page and API take from the network."""

    proxies: tuple[IPvAnyNetwork, ...] = ()
    """Addresses or networks of proxies; who they say is calling is believed, and of nobody else."""
    body_kb: int = Field(default=1024, ge=16, le=16_384)
    """Largest body of a call that is no upload, kB (10^3 bytes)."""
    upload_mb: int = Field(default=4000, ge=1, le=1_000_000)
    """Largest recording that may be uploaded, MB (10^6 bytes)."""
    uploads_gb: float = Field(default=20.0, ge=0.0)
    """All uploaded recordings together, GB (10^9 bytes); they count in [storage] quota_gb too."""
    connections: int = Field(default=100, ge=4, le=10_000)
    """Connections one address may hold at once; those of proxies are not counted."""
    header_s: float = Field(default=10.0, gt=0.0, le=120.0)
    """Time a caller has to send the headers of a call, s."""
    body_s: float = Field(default=10.0, gt=0.0, le=120.0)
    """Time it has to send the body, s; of an upload, the longest pause."""
    bad_keys: int = Field(default=10, ge=1, le=1000)
    """Calls with a bad key that an address may make at once."""
    bad_key_every_s: float = Field(default=6.0, gt=0.0, le=3600.0)
    """Afterwards it may try one in so many seconds, s."""

    login_h: float = Field(default=12.0, gt=0.0, le=720.0)
    """How long a person who has logged in with a browser need not do so again, h: a shift."""

    @model_validator(mode="after")
    def _believes_not_everybody(self) -> Self:
        if any(network.prefixlen == 0 for network in self.proxies):
            raise ValueError("proxies hold every address; name those of your proxies alone")
        return self
