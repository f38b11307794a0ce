"""Looking at the certificate of the API before anything is started."""

import ssl
from pathlib import Path

from station.errors import InputUnusable
from station.settings import TlsSettings


def ensure_tls_usable(tls: TlsSettings | None) -> None:
    """Refuse a certificate and key that no server could show, before anything is started.

    Raises
    ------
    InputUnusable
        If a file cannot be read, or is not what it should be.
    """
    if tls is None:
        return
    for what, path in (("certificate", tls.certificate), ("key", tls.key)):
        _ensure_readable(what, path)
    try:
        # An empty password, as none is asked for at a terminal that a service does not have.
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(
            tls.certificate, tls.key, password=""
        )
    except (ssl.SSLError, OSError) as error:
        why = getattr(error, "reason", None) or "no certificate with its key, PEM, no password"
        raise InputUnusable(
            f"[tls] {tls.certificate} and {tls.key}: {str(why).replace('_', ' ').lower()}; "
            "give a certificate and the key that belongs to it"
        ) from error


def _ensure_readable(what: str, path: Path) -> None:
    try:
        with path.open("rb"):
            pass
    except OSError as error:
        raise InputUnusable(
            f"[tls] {what} {path}: cannot be read ({error.strerror}); "
            "give one that the station's user may read"
        ) from error
