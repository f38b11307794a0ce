"""The contract of the API as OpenAPI."""

from copy import deepcopy
from typing import Any

from fastapi import FastAPI

from station.api.bodies import STREAMED
from station.api.problems import Problem

_FRAMEWORKS_OWN = ("HTTPValidationError", "ValidationError")
_IDEMPOTENCY_KEY = {
    "name": "Idempotency-Key",
    "in": "header",
    "required": False,
    "description": "The same key again gets the same answer for a day, and nothing is done twice.",
    "schema": {"type": "string", "minLength": 1, "maxLength": 255, "pattern": "^[!#-~]+$"},
}
_OF_LONG_WORK = {
    "Location": {"description": "The job, or what it works on.", "schema": {"type": "string"}},
    "Retry-After": {"description": "Seconds until a look pays.", "schema": {"type": "integer"}},
}


def contract_of(app: FastAPI) -> dict[str, Any]:
    """Return the contract of an app as it is: with its problem documents and its middleware.

    The framework describes a refusal of its own that the station never sends, and knows nothing of
    what happens around the routes.
    """
    contract = deepcopy(app.openapi())
    schemas: dict[str, Any] = contract["components"]["schemas"]
    for name in _FRAMEWORKS_OWN:
        schemas.pop(name, None)
    schemas.setdefault(Problem.__name__, Problem.model_json_schema())
    for path, operations in contract["paths"].items():
        for method, operation in operations.items():
            refusal = operation["responses"].get("422", {})
            if "application/json" in refusal.get("content", {}):
                del operation["responses"]["422"]  # `default` has it
            if "202" in operation["responses"]:
                operation["responses"]["202"]["headers"] = _OF_LONG_WORK
            if method == "post" and ("POST", path) not in STREAMED:
                operation.setdefault("parameters", []).append(_IDEMPOTENCY_KEY)
    return contract
