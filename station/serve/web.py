"""How the API meets the network: whom it believes, and for whom it waits how long."""

import uvicorn
from fastapi import FastAPI

from station.serve.patience import patient_http
from station.settings import StationSettings

_GRACE_S = 3


def server_config(app: FastAPI, settings: StationSettings) -> uvicorn.Config:
    """Return how the server of the API is to run."""
    web, tls = settings.web, settings.tls
    return uvicorn.Config(
        app,
        http=patient_http(web),
        ws="none",
        access_log=False,
        log_config=None,
        server_header=False,
        # Who calls is who connects, unless that is a proxy of the settings, which says who it is.
        proxy_headers=bool(web.proxies),
        forwarded_allow_ips=[str(network) for network in web.proxies],
        ssl_certfile=None if tls is None else tls.certificate,
        ssl_keyfile=None if tls is None else tls.key,
        # An event stream lasts as long as its job; the stop does not wait for it.
        timeout_graceful_shutdown=_GRACE_S,
    )
