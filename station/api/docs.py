"""A page that lists the operations; it loads nothing from anywhere."""

from html import escape
from typing import Any

_STYLE = (
    "body{font:15px/1.5 system-ui;max-width:60rem;margin:2rem auto;padding:0 1rem}"
    "code{font:14px ui-monospace,monospace}td{padding:.2rem 1rem .2rem 0;vertical-align:top}"
)


def docs_page(schema: dict[str, Any]) -> str:
    """Return the operations of an OpenAPI document as a page."""
    info = schema["info"]
    rows = "".join(
        f"<tr><td><code>{escape(method.upper())}</code></td><td><code>{escape(path)}</code></td>"
        f"<td>{escape(operation.get('description', ''))}</td></tr>"
        for path, operations in schema["paths"].items()
        for method, operation in operations.items()
    )
    title = escape(f"{info['title']} {info['version']}")
    return (
        f"<!doctype html><html lang=en><meta charset=utf-8><title>{title}</title>"
        f"<style>{_STYLE}</style><h1>{title}</h1><p>{escape(info['description'])}</p>"
        f"<p>The whole contract: <a href=/openapi.json>/openapi.json</a></p>"
        f"<table>{rows}</table></html>"
    )
