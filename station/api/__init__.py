"""The HTTP face of the station: parse, call, answer."""

from station.api.actors import By
from station.api.app import API_VERSION, build_app, contract
from station.api.callers import Administrator, Calibrator, Operator, Reader
from station.api.logins import CSRF_HEADER, LoggedIn, cookie_in
from station.api.paging import cursor_in, next_of
from station.api.parts import Parts, PartsOf
from station.api.problems import status_of
from station.api.refusals import TooManyBadKeys
from station.api.remembered import for_a_moment, from_the_store
from station.api.requests import CallersId, Count, IdInPath, RigInPath, SensorInPath, TrainName

__all__ = [
    "API_VERSION",
    "Administrator",
    "By",
    "CSRF_HEADER",
    "CallersId",
    "Calibrator",
    "Count",
    "IdInPath",
    "LoggedIn",
    "Operator",
    "Parts",
    "PartsOf",
    "Reader",
    "RigInPath",
    "SensorInPath",
    "TooManyBadKeys",
    "TrainName",
    "build_app",
    "contract",
    "cookie_in",
    "cursor_in",
    "for_a_moment",
    "from_the_store",
    "next_of",
    "status_of",
]
