"""The settings as text: each with its unit, what it is without one, and what it means."""

from collections.abc import Iterator, Mapping
from types import UnionType
from typing import Any, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined


def explained(model: type[BaseModel], prefix: str = "") -> Iterator[dict[str, Any]]:
    """Yield the settings of a table and those below it: name, meaning, default, whether needed.

    Of a list of tables the name ends in ``[]``, of tables by name in ``.NAME``.
    """
    for name, field in model.model_fields.items():
        inner, form = _table_in(field.annotation)
        yield {
            "name": f"{prefix}{name}{form}",
            "meaning": " ".join((field.description or "").split()),
            "default": _default(field, table=inner is not None),
            "needed": field.is_required(),
            "table": inner is not None,
        }
        if inner is not None:
            yield from explained(inner, f"{prefix}{name}{form}.")


def _table_in(annotation: Any) -> tuple[type[BaseModel] | None, str]:
    """Return the table that a setting holds, if it holds one, and what follows its name."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation, ""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin in {tuple, list}:
        return _table_in(arguments[0])[0], "[]" if _table_in(arguments[0])[0] else ""
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return _table_in(arguments[1])[0], ".NAME"
    if origin in {Union, UnionType}:
        found = [_table_in(each) for each in arguments]
        return next((each for each in found if each[0] is not None), (None, ""))
    return None, ""


def _default(field: FieldInfo, *, table: bool) -> Any:
    if field.default is not PydanticUndefined and not table:
        return field.default
    return None
