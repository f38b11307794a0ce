"""What a route asks of its caller: a key, and a scope."""

from collections.abc import Awaitable, Callable
from typing import Annotated

from fastapi import Depends, Request, Security
from fastapi.security import HTTPAuthorizationCredentials, HTTPBearer

from station.errors import ScopeMissing
from station.store.callers import Caller, Scope

# For the contract; what it finds is not used.
_bearer = HTTPBearer(auto_error=False, description="A key of the station.")


def needs(scope: Scope) -> Callable[..., Awaitable[Caller]]:
    """Return a dependency that lets only callers with `scope` through, and says who calls.

    The guard has refused those without a key before any route is looked for.
    """

    # Async, as all dependencies that wait for nothing: a plain one is called in another thread,
    # which costs more than what it does.
    async def admitted(
        request: Request,
        _: Annotated[HTTPAuthorizationCredentials | None, Security(_bearer)],
    ) -> Caller:
        caller: Caller = request.state.caller
        ensure_may(caller, scope)
        return caller

    return admitted


def ensure_may(caller: Caller, scope: Scope) -> None:
    """Let only callers with `scope` go on.

    Raises
    ------
    ScopeMissing
        If the caller has others.
    """
    if not caller.may(scope):
        raise ScopeMissing(
            f"the key {caller.name!r} has {', '.join(sorted(caller.scopes))}; "
            f"this call needs {scope}"
        )


Reader = Annotated[Caller, Depends(needs(Scope.READ))]
Operator = Annotated[Caller, Depends(needs(Scope.OPERATE))]
Calibrator = Annotated[Caller, Depends(needs(Scope.CALIBRATE))]
Administrator = Annotated[Caller, Depends(needs(Scope.ADMIN))]
