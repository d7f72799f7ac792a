"""Who may open the page: on this machine only pages of its own; from elsewhere whoever has the token."""

from __future__ import annotations

import hmac
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from ipaddress import ip_address
from typing import Any
from urllib.parse import parse_qs, urlsplit

Scope = MutableMapping[str, Any]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Application = Callable[[Scope, Receive, Send], Awaitable[None]]

COOKIE, PARAMETER = "heave_panel", "token"
PROTECTION = (
    (b"content-security-policy", b"frame-ancestors 'none'; object-src 'none'; base-uri 'self'; form-action 'self'"),
    (b"x-frame-options", b"DENY"),  # the first of these for browsers of before 2020
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),  # the address may hold the token
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
)
"""Headers of every answer: no other site shows the page in a frame, where clicks on it could be led astray."""
OWN_SITE = ("same-origin", "none")
"""What a browser says of who asks: this page, or its user, who has typed or opened the address; not another page."""
REFUSED = b"The token is missing or wrong, or another page asked: open the address that heave panel has printed.\n"


def is_loopback(host: str) -> bool:
    """Return whether `host`, a name or an address, is this machine and nothing else."""
    if host == "localhost":
        return True
    try:
        return ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


class Guard:
    """Lets requests through to an application, or not.

    Parameters
    ----------
    application : ASGI
    token : that a browser must bring once, in the address, and then as a cookie; "" where the page is served on
        localhost: then the browser must have asked for localhost, so that no other site can speak through it
    """

    def __init__(self, application: Application, token: str = "") -> None:
        self._application, self._token = application, token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request or connection."""
        send = _protected(send)
        if scope["type"] not in ("http", "websocket") or self._may_pass(scope):
            await self._application(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        elif self._has_token(self._given(scope)):
            cookie = f"{COOKIE}={self._token}; HttpOnly; SameSite=Strict; Path=/"
            await _answer(send, 303, b"", [(b"location", b"/"), (b"set-cookie", cookie.encode())])
        else:
            await _answer(send, 403, REFUSED, [])

    def _may_pass(self, scope: Scope) -> bool:
        headers = {name.decode("latin-1").lower(): value.decode("latin-1") for name, value in scope["headers"]}
        host = headers.get("host", "")
        origin = headers.get("origin", "")
        try:
            if headers.get("sec-fetch-site", "none") not in OWN_SITE or (origin and urlsplit(origin).netloc != host):
                return False
            if not self._token:
                return is_loopback(urlsplit(f"//{host}").hostname or "")
            cookies = SimpleCookie(headers.get("cookie", ""))
        except (ValueError, CookieError):  # no address, no cookie
            return False
        return COOKIE in cookies and self._has_token(cookies[COOKIE].value)

    @staticmethod
    def _given(scope: Scope) -> str:
        query: bytes = scope.get("query_string", b"")
        return parse_qs(query.decode("latin-1")).get(PARAMETER, [""])[0]

    def _has_token(self, given: str) -> bool:
        return bool(self._token) and hmac.compare_digest(given.encode(), self._token.encode())


def _protected(send: Send) -> Send:
    """Return `send` with the headers of PROTECTION in every answer, in the place of such as the application has."""
    names = {name for name, _ in PROTECTION}

    async def send_protected(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            others = [header for header in message.get("headers", ()) if header[0].lower() not in names]
            message = {**message, "headers": [*others, *PROTECTION]}
        await send(message)

    return send_protected


async def _answer(send: Send, status: int, body: bytes, headers: list[tuple[bytes, bytes]]) -> None:
    headers = [(b"content-type", b"text/plain; charset=utf-8"), *headers]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
