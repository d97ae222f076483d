"""Who may talk to the page: browsers that opened it here, or that know the token.

A page of somebody else, open in the same browser, can send requests to this machine too; they carry its origin, or ask
for a host of its choice, and are refused. So STOP and TAKE-OFF are pressed by people who see this page.
"""

from __future__ import annotations

import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

COOKIE = "crazychoir_token"
LARGEST_BODY = 4_000_000  # bytes
_LOCAL = ("127.0.0.1", "localhost", "[::1]")

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]


def is_loopback(host: str) -> bool:
    """Tell whether an address is that of this machine alone."""
    return host in ("127.0.0.1", "localhost", "::1")


class Guard:
    """Stands before an ASGI application."""

    def __init__(self, app: Any, token: str | None = None) -> None:
        """Guard an application.

        Args:
            app: The application.
            token: What whoever comes must know; without, only names of this machine are answered.
        """
        self._app = app
        self._token = token

    async def __call__(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        """Let a request pass, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = {key.decode("latin-1").lower(): value.decode("latin-1") for key, value in scope["headers"]}
        refusal = self._refusal(scope, headers)
        if refusal is not None:
            await _refuse(scope, send, receive, *refusal)
            return
        if self._token is not None and scope["type"] == "http":
            send = self._with_cookie(scope, send)
        await self._app(scope, receive, send)

    def _refusal(self, scope: MutableMapping[str, Any], headers: dict[str, str]) -> tuple[int, str] | None:
        host = headers.get("host", "")
        name = host.rpartition(":")[0] if host.rpartition(":")[2].isdigit() else host
        if self._token is None and name not in _LOCAL:
            return 403, f"this page answers to {', '.join(_LOCAL)} only; start it with --host and --token for others"
        origin = headers.get("origin")
        if origin is not None:
            try:
                is_ours = urlsplit(origin).netloc == host
            except ValueError:
                is_ours = False
            if not is_ours:
                return 403, "requests of other pages are not carried out"
        if self._token is not None and not self._knows_token(scope, headers):
            return 401, "open the page with its token: http://HOST:PORT/?token=TOKEN"
        length = headers.get("content-length", "0")
        if scope["type"] == "http" and (not length.isdigit() or int(length) > LARGEST_BODY):
            return 413, f"the request is larger than {LARGEST_BODY} bytes"
        return None

    def _knows_token(self, scope: MutableMapping[str, Any], headers: dict[str, str]) -> bool:
        given = [*_query(scope).get("token", []), headers.get("authorization", "").removeprefix("Bearer ")]
        try:
            morsel = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
        except CookieError:
            morsel = None
        if morsel is not None:
            given.append(morsel.value)
        return any(secrets.compare_digest(one.encode(), self._token.encode()) for one in given)

    def _with_cookie(self, scope: MutableMapping[str, Any], send: Send) -> Send:
        """Let the browser remember the token that came with the address."""
        if not _query(scope).get("token"):
            return send
        cookie = f"{COOKIE}={self._token}; Path=/; HttpOnly; SameSite=Strict".encode("latin-1")

        async def send_with_cookie(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message.get("headers", []), (b"set-cookie", cookie)]
            await send(message)

        return send_with_cookie


def _query(scope: MutableMapping[str, Any]) -> dict[str, list[str]]:
    return parse_qs(scope.get("query_string", b"").decode("latin-1"))


async def _refuse(scope: MutableMapping[str, Any], send: Send, receive: Receive, status: int, text: str) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 4403, "reason": text[:120]})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8")]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": text.encode()})
