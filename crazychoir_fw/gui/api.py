"""The endpoints of the page. Whatever is wrong with a request is said in a sentence: ``{"ok": false, "text": ...}``."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import BaseRoute, Route, WebSocketRoute

from crazychoir_fw.common.errors import CrazychoirError, RangeError, StateError, UnknownNameError
from crazychoir_fw.gui import requests as asked
from crazychoir_fw.gui.drawings import EXAMPLES
from crazychoir_fw.gui.flight_record import FORMATS, check_format, parts_of, record_of
from crazychoir_fw.gui.previews import about, dry_run
from crazychoir_fw.gui.setting import setting_of

if TYPE_CHECKING:
    from crazychoir_fw.gui.commands import Commands
    from crazychoir_fw.gui.drawings import Drawings
    from crazychoir_fw.gui.live import Live
    from crazychoir_fw.gui.previews import Previews
    from crazychoir_fw.gui.session import Session

ANSWER_S = 30.0
"""Longest time until a command is answered (s)."""


class Api:
    """What browsers, and `crazychoir press`, talk to."""

    def __init__(
        self, session: Session, commands: Commands, drawings: Drawings, previews: Previews, live: Live
    ) -> None:
        self._session = session
        self._commands = commands
        self._drawings = drawings
        self._previews = previews
        self._live = live

    def routes(self) -> list[BaseRoute]:
        """Return all endpoints."""
        return [
            Route("/api/setting", _spoken(self._setting), methods=["GET"]),
            Route("/api/command", _spoken(self._command), methods=["POST"]),
            Route("/api/drawings", _spoken(self._read_drawings), methods=["GET"]),
            Route("/api/drawings", _spoken(self._change_drawings), methods=["POST"]),
            Route("/api/drawings/{key}.csv", _spoken(self._export), methods=["GET"]),
            Route("/api/preview", _spoken(self._preview), methods=["POST"]),
            Route("/api/dry_run", _spoken(self._dry_run), methods=["POST"]),
            Route("/api/parameters", _spoken(self._parameters), methods=["GET"]),
            Route("/api/path", _spoken(self._path), methods=["GET"]),
            Route("/api/log.{kind}", _spoken(self._log), methods=["GET"]),
            WebSocketRoute("/api/live", self._live.serve),
        ]

    async def _setting(self, request: Request) -> Response:
        if not self._session.is_ready:
            return _answer({"ready": False, "error": self._session.error})
        return _answer({"ready": True, **await run_in_threadpool(setting_of, self._session)})

    async def _command(self, request: Request) -> Response:
        envelope = asked.read(asked.Envelope, await _json(request))
        future = await run_in_threadpool(self._commands.send, envelope)
        return _answer({"text": await _result(future)})

    async def _read_drawings(self, request: Request) -> Response:
        return _answer(self._drawings.about())

    async def _change_drawings(self, request: Request) -> Response:
        envelope = asked.read(asked.DrawingEnvelope, await _json(request))

        def carry_out() -> Future[Any]:
            future: Future[Any] = Future()
            try:
                future.set_result(self._change(envelope.change))
            except Exception as error:
                future.set_exception(error)
            return future

        future = await run_in_threadpool(self._session.once, "drawing " + envelope.id, carry_out)
        return _answer({"text": await _result(future), **self._drawings.about()})

    def _change(self, change: Any) -> str:
        drawings = self._drawings
        if isinstance(change, asked.NewDrawing):
            rows = [(x, y, change.height) for x, y, _ in change.points]
            return f"'{drawings.add(rows, [row[2] for row in change.points], change.name).name}' is drawn"
        if isinstance(change, asked.ChangeDrawing):
            return f"'{drawings.change(change.drawing, change.name, change.height, change.drone).name}' is changed"
        if isinstance(change, asked.DeleteDrawing):
            drawings.delete(change.drawing)
            return "deleted; UNDO brings it back"
        if isinstance(change, asked.UndoDrawing):
            drawings.undo()
            return "undone"
        if change.action == "save":
            return f"saved in {drawings.save(change.name)}"
        if change.action == "import":
            return f"'{drawings.take_in(change.name, change.text).name}' is taken in"
        count = drawings.load(change.name, EXAMPLES if change.action == "example" else None)
        return f"'{change.name}' has {count} drawings"

    async def _export(self, request: Request) -> Response:
        drawing = self._drawings.find(request.path_params["key"])
        name = "".join(c if c.isalnum() and c.isascii() else "_" for c in drawing.name)
        headers = {"content-disposition": f'attachment; filename="{name}.csv"'}
        return PlainTextResponse(drawing.csv(), headers=headers, media_type="text/csv")

    async def _preview(self, request: Request) -> Response:
        wish = asked.read(asked.PreviewRequest, await _json(request))

        def make() -> dict[str, Any]:
            return about(self._previews.make(wish))

        return _answer(await run_in_threadpool(make))

    async def _dry_run(self, request: Request) -> Response:
        data = await _json(request)
        if not isinstance(data, dict) or not isinstance(data.get("preview"), str):
            raise RangeError('a dry run needs {"preview": KEY}')
        preview = self._previews.find(data["preview"])
        session = self._session

        def run() -> dict[str, Any]:
            try:
                return dry_run(session.mission, preview, lambda share: setattr(session, "dry_share", share))
            finally:
                session.dry_share = None

        return _answer(await run_in_threadpool(run))

    async def _parameters(self, request: Request) -> Response:
        name = request.query_params.get("drone", self._session.names[0])
        if name not in self._session.names:
            raise UnknownNameError(f"there is no drone '{name[:40]}'")
        index, access = self._session.names.index(name), self._session.access
        if access is None:
            raise RangeError("the drones are not ready yet")
        if access.is_slow(index):
            found = await run_in_threadpool(access.parameters, index)
        else:
            found = await _result(self._session.ask(lambda: access.parameters(index)))
        return _answer({"drone": name, "parameters": [variable.as_dict() for variable in found]})

    async def _path(self, request: Request) -> Response:
        try:
            number, begin = int(request.query_params["branch"]), float(request.query_params.get("begin", 0.0))
        except (KeyError, ValueError):
            raise RangeError("a path needs ?branch=NUMBER, and perhaps &begin=SECONDS") from None
        return _answer(await run_in_threadpool(self._session.branches.path, number, begin))

    async def _log(self, request: Request) -> Response:
        session = self._session
        if not session.is_ready:
            raise StateError(session.error or "the drones are not ready yet")
        try:
            number = int(request.query_params["branch"]) if "branch" in request.query_params else None
        except ValueError:
            raise RangeError("a log needs ?branch=NUMBER, or nothing for the branch that is flown") from None
        kind = check_format(f"log.{request.path_params['kind']}")
        log = await run_in_threadpool(record_of, session, number)
        name = "".join(c if c.isalnum() and c.isascii() else "_" for c in session.mission.name)
        headers = {"content-disposition": f'attachment; filename="{name}.{kind}"'}
        return StreamingResponse(parts_of(log, kind), headers=headers, media_type=FORMATS[kind])


async def _result(future: Future[Any]) -> Any:
    try:
        return await asyncio.wait_for(asyncio.shield(asyncio.wrap_future(future)), ANSWER_S)
    except (TimeoutError, asyncio.TimeoutError):
        raise RangeError(f"no answer within {ANSWER_S:g} s; the flight is busy, the command may still come") from None


async def _json(request: Request) -> Any:
    """Return the body; other pages cannot send this type of content without being asked."""
    if request.headers.get("content-type", "").partition(";")[0].strip().lower() != "application/json":
        raise RangeError("the content-type must be application/json")
    try:
        return json.loads(await request.body())
    except (ValueError, RecursionError):
        raise RangeError("the request is no JSON") from None


def _answer(data: dict[str, Any], status: int = 200) -> Response:
    return JSONResponse({"ok": status == 200, **data}, status_code=status)


def _spoken(endpoint: Callable[[Request], Awaitable[Response]]) -> Callable[[Request], Awaitable[Response]]:
    """Turn errors into sentences."""

    async def answer(request: Request) -> Response:
        try:
            return await endpoint(request)
        except CrazychoirError as error:
            status = 422 if isinstance(error, RangeError) else 409
            return _answer({"text": str(error)}, status)
        except OSError as error:
            return _answer({"text": f"{error.filename}: {error.strerror}"}, 409)

    return answer
