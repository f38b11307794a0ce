"""Which methods an address has."""

from fastapi import FastAPI
from starlette.routing import compile_path


def methods_at(app: FastAPI, path: str) -> list[str]:
    """Return the methods that the contract knows at an address, in order of the alphabet."""
    paths = app.openapi()["paths"]
    matching = [path] if path in paths else [t for t in paths if compile_path(t)[0].fullmatch(path)]
    return sorted({method.upper() for template in matching for method in paths[template]})
