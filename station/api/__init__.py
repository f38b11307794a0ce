"""The HTTP face of the station: parse, call, answer."""

from station.api.app import API_VERSION, build_app, contract

__all__ = ["API_VERSION", "build_app", "contract"]
