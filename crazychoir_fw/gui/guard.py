"""Which browsers may talk to the page: those that opened it here, or that know the token.

A foreign page, open in the same browser, can send requests to this machine too; they carry its origin, or ask for a
host of its choice, and are refused. Nor can it show this page in a frame and lead a click to a button. So STOP and
TAKE-OFF are pressed only by users who see this page.
"""

from __future__ import annotations

import re
import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

COOKIE = "crazychoir_token"
LARGEST_BODY = 4_000_000  # bytes
_TOO_LARGE = f"the request is larger than {LARGEST_BODY} bytes"
_LOCAL = ("127.0.0.1", "localhost", "[::1]")
_TOKEN = re.compile(r"[A-Za-z0-9._~-]{8,200}")  # as it is in links, headers and cookies
_HEADERS = [
    # templates of Vue are compiled in the browser, and NiceGUI writes scripts and styles into its page
    (
        b"content-security-policy",
        b"default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
        b"img-src 'self' data: blob:; font-src 'self' data:; worker-src 'self' blob:; object-src 'none'; "
        b"base-uri 'self'; form-action 'self'; frame-ancestors 'none'",
    ),
    (b"x-frame-options", b"DENY"),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),  # the address may hold the token
]

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]


def is_loopback(host: str) -> bool:
    """Tell whether an address is that of this machine alone."""
    return host in ("127.0.0.1", "localhost", "::1")


def new_token() -> str:
    """Return a token that cannot be guessed."""
    return secrets.token_urlsafe(16)


def is_token(text: str) -> bool:
    """Tell whether a text can be a token: 8 to 200 letters, digits and ``. _ ~ -``."""
    return _TOKEN.fullmatch(text) is not None


class Guard:
    """Stands before an ASGI application."""

    def __init__(self, app: Any, token: str | None = None) -> None:
        """Guard an application.

        Args:
            app: The application.
            token: Secret that each request must carry; without it, only names of this machine are answered.
        """
        self._app = app
        self._token = token

    async def __call__(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        """Let a request pass, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = {key.decode("latin-1").lower(): value.decode("latin-1") for key, value in scope["headers"]}
        if scope["type"] == "http":
            send = self._with_headers(scope, send)
        refusal = self._refusal(scope, headers)
        if refusal is not None:
            await _refuse(scope, send, receive, *refusal)
        elif scope["type"] == "websocket":
            await self._app(scope, receive, send)
        else:
            exchange = _Exchange(scope, receive, send)
            try:
                await self._app(scope, exchange.receive, exchange.send)
            except Exception:
                if not exchange.is_refused:
                    raise

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
            return 413, _TOO_LARGE
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

    def _with_headers(self, scope: MutableMapping[str, Any], send: Send) -> Send:
        """Tell the browser what it may do with the page, and to remember the token that came with the address."""
        headers = list(_HEADERS)
        if self._token is not None and _query(scope).get("token") == [self._token]:
            headers.append((b"set-cookie", f"{COOKIE}={self._token}; Path=/; HttpOnly; SameSite=Strict".encode()))

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message.get("headers", []), *headers]
            await send(message)

        return send_with_headers


class _Exchange:
    """A request and its answer; counts the bytes of the body, which in chunks tells no length beforehand."""

    def __init__(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        self._scope, self._receive, self._send = scope, receive, send
        self._size = 0
        self.is_refused = False
        """Whether it was answered in the place of the application, which takes the client for gone."""

    async def receive(self) -> Message:
        message = await self._receive()
        self._size += len(message.get("body", b""))
        if self._size <= LARGEST_BODY:
            return message
        if not self.is_refused:
            self.is_refused = True
            await _refuse(self._scope, self._send, self._receive, 413, _TOO_LARGE)
        return {"type": "http.disconnect"}

    async def send(self, message: Message) -> None:
        if not self.is_refused:
            await self._send(message)


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
