"""What a route asks of its caller: a key, and a scope."""

from collections.abc import Callable
from typing import Annotated

from fastapi import Depends, Security
from fastapi.security import HTTPAuthorizationCredentials, HTTPBearer

from station.api.parts import PartsOf
from station.errors import KeyRefused, ScopeMissing
from station.store import Caller, Scope

_bearer = HTTPBearer(auto_error=False, description="A key of the station.")


def needs(scope: Scope) -> Callable[..., Caller]:
    """Return a dependency that lets only callers with `scope` through, and says who calls."""

    def admitted(
        parts: PartsOf,
        given: Annotated[HTTPAuthorizationCredentials | None, Security(_bearer)],
    ) -> Caller:
        if given is None:
            raise KeyRefused("this call needs a key; send it as `Authorization: Bearer KEY`")
        caller = parts.gate.admit(given.credentials)
        if not caller.may(scope):
            raise ScopeMissing(
                f"the key {caller.name!r} has {', '.join(sorted(caller.scopes))}; "
                f"this call needs {scope}"
            )
        return caller

    return admitted


Reader = Annotated[Caller, Depends(needs(Scope.READ))]
Operator = Annotated[Caller, Depends(needs(Scope.OPERATE))]
Calibrator = Annotated[Caller, Depends(needs(Scope.CALIBRATE))]
