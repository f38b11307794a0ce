"""The contract of the API as OpenAPI."""

from typing import Any

from fastapi import FastAPI

from station.api.problems import Problem


def contract_of(app: FastAPI) -> dict[str, Any]:
    """Return the contract of an app with the problem documents, which the framework leaves out."""
    contract = app.openapi()
    schemas: dict[str, Any] = contract["components"]["schemas"]
    schemas.setdefault(Problem.__name__, Problem.model_json_schema())
    return contract
