"""Serves the page of one flight."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from crazychoir_fw.common.errors import MissingLibraryError, RangeError
from crazychoir_fw.gui.guard import Guard, is_loopback, is_token, new_token

if TYPE_CHECKING:
    from crazychoir_fw.gui.live import Live
    from crazychoir_fw.gui.session import Session
    from crazychoir_fw.gui.viewing import Viewing


def require_nicegui() -> None:
    """See that the libraries of the page are there.

    Raises:
        MissingLibraryError: If they are not.
    """
    try:
        import nicegui  # noqa: F401
    except ImportError:
        raise MissingLibraryError("the page needs NiceGUI: run pip install 'crazychoir-fw[gui]'") from None


def make_app(session: Session, folder: Path | None = None, token: str | None = None, with_page: bool = True) -> Any:
    """Return the ASGI application of a flight.

    Args:
        session: The flight.
        folder: Where drawings are saved.
        token: What browsers must know.
        with_page: Whether there is the page, beside the endpoints; one per process.
    """
    from fastapi import FastAPI

    from crazychoir_fw.gui.api import Api
    from crazychoir_fw.gui.commands import Commands
    from crazychoir_fw.gui.drawings import Drawings
    from crazychoir_fw.gui.live import Live
    from crazychoir_fw.gui.previews import Previews
    from crazychoir_fw.gui.words import Words

    drawings = Drawings(session.names, Path("drawings") if folder is None else folder)
    previews = Previews(session.mission, drawings)
    live = Live(session, Words(session, drawings))
    api = Api(session, Commands(session, previews), drawings, previews, live)
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    app.router.routes.extend(api.routes())
    app.state.drawings = drawings
    if with_page:
        from crazychoir_fw.gui.page import mount

        mount(app, session)
    return Guard(app, token)


def serve(
    session: Session, host: str = "127.0.0.1", port: int = 8080, token: str | None = None, folder: Path | None = None
) -> None:
    """Serve until Ctrl-C.

    Raises:
        RangeError: If the token is none.
    """
    server = make_server(session, host, port, token_for(host, False, token), folder)
    server.run()


def token_for(host: str, is_real: bool, token: str | None) -> str | None:
    """Return the token that browsers must know; None where programs of this machine need none.

    Args:
        host: Address that is listened to.
        is_real: Whether drones are real: other users of this machine must not fly them.
        token: What was chosen; without, one is made where one is needed.

    Raises:
        RangeError: If it is none.
    """
    if token is not None and not is_token(token):
        raise RangeError("--token must be 8 to 200 letters, digits or any of . _ ~ -")
    if token is None and (is_real or not is_loopback(host)):
        return new_token()
    return token


def make_server(
    session: Session,
    host: str = "127.0.0.1",
    port: int = 8080,
    token: str | None = None,
    folder: Path | None = None,
) -> Any:
    """Return a uvicorn server, not started yet."""
    return _server(make_app(session, folder, token), host, port)


def make_view_server(viewing: Viewing) -> tuple[Any, Live]:
    """Return a server of a page to look at, not started yet, and what tells its browsers."""
    from fastapi import FastAPI
    from starlette.responses import JSONResponse
    from starlette.routing import Route, WebSocketRoute

    from crazychoir_fw.gui.live import Live
    from crazychoir_fw.gui.page import mount_view

    live = Live(viewing, viewing.words)

    async def setting(request: Any) -> JSONResponse:
        del request
        return JSONResponse({"ok": True, "ready": True, **viewing.setting()})

    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    app.router.routes.extend([Route("/api/setting", setting), WebSocketRoute("/api/live", live.serve)])
    mount_view(app, viewing.title)
    return _server(Guard(app)), live


def _server(app: Any, host: str = "127.0.0.1", port: int = 0) -> Any:
    import uvicorn

    config = uvicorn.Config(
        app, host=host, port=port, log_level="warning", ws_max_size=1_000_000, timeout_graceful_shutdown=2
    )
    return uvicorn.Server(config)
