"""The HTTP face of the station: parse, call, answer."""

from station.api.actors import By
from station.api.app import API_VERSION, build_app, contract
from station.api.callers import Administrator, Calibrator, Operator, Reader
from station.api.logins import CSRF_HEADER, LoggedIn
from station.api.parts import Parts, PartsOf
from station.api.remembered import for_a_moment, from_the_store

__all__ = [
    "API_VERSION",
    "Administrator",
    "By",
    "CSRF_HEADER",
    "Calibrator",
    "LoggedIn",
    "Operator",
    "Parts",
    "PartsOf",
    "Reader",
    "build_app",
    "contract",
    "for_a_moment",
    "from_the_store",
]
