"""What surrounds every page: templates, texts, formats, navigation, and cautious headers."""

import gzip
import json
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated, Any, Final
from zoneinfo import ZoneInfo

from fastapi import Depends, Request, Response
from fastapi.responses import HTMLResponse
from jinja2 import Environment, PackageLoader, PrefixLoader, StrictUndefined

from station.api import LoggedIn
from station.page.assets import PAGES, Assets
from station.page.formats import Times, bytes_of, lasting, quantity
from station.page.going import REDIRECT
from station.page.texts import LANGUAGE, Texts
from station.settings import StationSettings
from station.store.callers import Caller, Scope

# Nothing from elsewhere and nothing inline: what a pass id or an operator wrote is never a script.
CONTENT_SECURITY_POLICY: Final = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
    "connect-src 'self'; form-action 'self'; frame-ancestors 'none'; base-uri 'none'"
)
_HEADERS: Final = {
    "Content-Security-Policy": CONTENT_SECURITY_POLICY,
    # Without a referrer a browser sends `Origin: null` with a form, as for somebody else's page.
    "Referrer-Policy": "same-origin",
}
_PACKED: Final = {"Content-Encoding": "gzip"}
_EFFORT: Final = 4
"""Beyond, a part of 20 kB takes twice as long and becomes hardly smaller."""
_NOBODY: Final = Caller("", frozenset())


@dataclass(frozen=True, slots=True)
class Shell:
    """Makes pages, and parts of pages, of templates."""

    station_name: str
    templates: Environment
    texts: Texts
    assets: Assets

    @classmethod
    def of(cls, settings: StationSettings) -> "Shell":
        """Make the shell of a station."""
        zone = None if settings.time_zone is None else ZoneInfo(settings.time_zone)
        texts, assets, times = Texts.of(), Assets.read(), Times(zone)
        templates = Environment(
            loader=PrefixLoader(
                {"shell": PackageLoader("station.page", "templates")}
                | {page: PackageLoader(f"station.page.{page}", "templates") for page in PAGES}
            ),
            autoescape=True,
            undefined=StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
            auto_reload=False,
        )
        templates.filters.update(
            when=times.when,
            clock=times.clock,
            ago=times.ago,
            quantity=quantity,
            bytes=bytes_of,
            lasting=lasting,
        )
        templates.globals.update(
            t=texts.say,
            texts_below=texts.below,
            static=assets.address,
            language=LANGUAGE,
            pages=PAGES,
            station_name=settings.name,
            zone=settings.time_zone or "",
        )
        return cls(settings.name, templates, texts, assets)

    def page(
        self, request: Request, template: str, *, status: int = 200, **context: Any
    ) -> HTMLResponse:
        """Return a page, or a part of one, made of a template.

        Templates know besides `context`: `caller`, `may` (a scope), `csrf_token`, `now` (UTC), and
        what `of` makes known to all.
        """
        caller: Caller = getattr(request.state, "caller", _NOBODY)
        logged_in: LoggedIn | None = getattr(request.state, "logged_in", None)
        text = self.templates.get_template(template).render(
            caller=caller,
            may=lambda scope: caller.may(Scope(scope)),
            csrf_token="" if logged_in is None else logged_in.csrf_token,
            now=datetime.now(UTC),
            path=request.url.path,
            **context,
        )
        return HTMLResponse(text, status_code=status, headers=_HEADERS)

    def packed(self, request: Request, template: str, **context: Any) -> HTMLResponse:
        """Return a part of a page that is asked for again and again, small where that is taken.

        No part in which a secret of the browser stands, as its token: beside what somebody else
        had written there, the length of the answer would tell it letter by letter.
        """
        plain = self.page(request, template, **context)
        plain.headers["Vary"] = "Accept-Encoding"
        if "gzip" not in request.headers.get("accept-encoding", ""):
            return plain
        small = gzip.compress(bytes(plain.body), _EFFORT, mtime=0)
        headers = {**_HEADERS, **_PACKED, "Vary": "Accept-Encoding"}
        return HTMLResponse(small, headers=headers)

    def done(self, said: str, *, changed: str | None = None, to: str | None = None) -> Response:
        """Return the answer to a button that was pressed: what is said, and what follows.

        Parameters
        ----------
        said
            Shown to the person, and read out.
        changed
            An event on the page's body; the parts that wait for it are loaded anew.
        to
            The page that is gone to, where it is said.
        """
        events: dict[str, Any] = {"said": {"text": said}}
        if changed is not None:
            events[changed] = {}
        # ASCII: a header holds no other letter, and the page reads JSON.
        headers = {"HX-Trigger": json.dumps(events)}
        if to is not None:
            headers[REDIRECT] = to
        return Response(status_code=204, headers=headers)


async def _shell(request: Request) -> Shell:  # async: a plain one is called in another thread
    shell: Shell = request.app.state.shell
    return shell


ShellOf = Annotated[Shell, Depends(_shell)]
