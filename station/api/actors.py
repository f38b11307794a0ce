"""Who makes a change, as the audit trail keeps it."""

from typing import Annotated

from fastapi import Depends, Request

from station.store import Actor


async def _actor(request: Request) -> Actor:  # async: a plain one is called in another thread
    host = None if request.client is None else request.client.host
    return Actor(request.state.caller.name, host)


By = Annotated[Actor, Depends(_actor)]
"""The caller that the guard let in, and its address; the scope is another dependency's."""
