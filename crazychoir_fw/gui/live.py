"""What browsers are told while the drones fly: a frame 15 times a second as numbers, and words twice a second.

Frames are made once for all browsers. One that cannot keep up misses frames, and nobody waits for it.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np
from starlette.websockets import WebSocket, WebSocketDisconnect

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.gui.marks import Marks
from crazychoir_fw.gui.session import FRAME_S, PHASES, Frame

if TYPE_CHECKING:
    from crazychoir_fw.gui.drawings import Drawings
    from crazychoir_fw.gui.session import Session

WORDS_S = 0.5
NUMBERS = 11
"""Of each drone in a frame: position, attitude (xyzw), reference, phase."""
_MAX_WATCHED = 64  # variables of one browser
_MAX_WORDS = 50_000  # bytes of a message of a browser


def packed(frame: Frame) -> bytes:
    """Return a frame as float32: number, time (s), rate, and `NUMBERS` of each drone."""
    rows = np.hstack([frame.position, frame.orientation, frame.reference, frame.phase[:, None]])
    head = np.array([frame.number % 2**24, frame.time, frame.rate])
    return np.concatenate([head, rows.ravel()]).astype("<f4").tobytes()


class Live:
    """Tells all browsers; runs in the loop of the server."""

    def __init__(self, session: Session, drawings: Drawings) -> None:
        self._session = session
        self._drawings = drawings
        self._marks: Marks | None = None
        self._browsers: set[_Browser] = set()
        self._task: asyncio.Task[None] | None = None

    @property
    def count(self) -> int:
        """How many browsers watch."""
        return len(self._browsers)

    async def serve(self, socket: WebSocket) -> None:
        """Tell one browser, for as long as it listens."""
        await socket.accept()
        browser = _Browser(socket, self._session)
        self._browsers.add(browser)
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._tell_all())
        sending = asyncio.create_task(browser.send())
        try:
            await browser.listen()
        except (WebSocketDisconnect, RuntimeError):
            pass
        finally:
            self._browsers.discard(browser)
            self._session.watched.pop(browser, None)
            sending.cancel()
            with contextlib.suppress(asyncio.CancelledError, Exception):
                await sending

    async def _tell_all(self) -> None:
        shown, next_words = -1, 0.0
        loop = asyncio.get_running_loop()
        while self._browsers:
            frame = self._session.frame
            if frame is not None and frame.number != shown:
                shown = frame.number
                data = packed(frame)
                for browser in self._browsers:
                    browser.offer(data)
            if loop.time() >= next_words:
                next_words = loop.time() + WORDS_S
                words = await self._words()
                for browser in self._browsers:
                    browser.tell(words)
            else:
                for browser in self._browsers:
                    browser.plot()
            await asyncio.sleep(FRAME_S)

    async def _words(self) -> dict[str, Any]:
        """Return what changes slowly."""
        session = self._session
        words: dict[str, Any] = {
            "speed": session.speed,
            "error": session.error,
            "ready": session.is_ready,
            "browsers": self.count,
            "drawings": self._drawings.version,
            "branch": session.branches.present.number,
            "branches": session.branches.about(),
            "no_rewind": session.no_rewind,
            "flying": None,
        }
        flying = session.flying
        if flying is not None:
            words["flying"] = {"name": flying.name, "phase": flying.phase, "started": flying.started,
                               "duration": round(flying.duration, 1)}  # fmt: skip
        if session.is_ready and session.error is None:
            try:
                if self._marks is None:
                    self._marks = Marks(session)
                marks = self._marks
                told = session.ask(lambda: (_cards(session), marks.now()))
                words["cards"], words["marks"] = await asyncio.wait_for(asyncio.wrap_future(told), 2.0)
            except (CrazychoirError, TimeoutError, asyncio.TimeoutError):
                pass  # a flight that makes real drones ready answers later
        return words


def _cards(session: Session) -> list[dict[str, Any]]:
    session.listen_to_consoles()
    cards = []
    for agent in session.experiment.agents:
        state = session.access.state(agent.index)
        guidance = getattr(getattr(agent.guidance, "phase", None), "value", "")
        cards.append(
            {
                "phase": agent.phase.value,
                "guidance": f"{type(agent.guidance).__name__} {guidance}".strip(),
                "supervisor": state.supervisor,
                "battery": round(state.battery_v, 3) if math.isfinite(state.battery_v) else None,
                "estimate_error": round(state.estimate_error_m, 4) if math.isfinite(state.estimate_error_m) else None,
                "link": state.link,
                "failure": agent.failure or state.failure,
            }
        )
    return cards


class _Browser:
    """One browser: the latest frame for it, and words that it has not heard."""

    def __init__(self, socket: WebSocket, session: Session) -> None:
        self._socket = socket
        self._session = session
        self._frame: bytes | None = None
        self._words: list[str] = []
        self._wake = asyncio.Event()
        self._heard = 0
        self._plotted = -math.inf

    def offer(self, frame: bytes) -> None:
        """Have the latest frame for it."""
        self._frame = frame
        self._wake.set()

    def tell(self, words: dict[str, Any]) -> None:
        """Say something that it must hear, if it listens at all."""
        if len(self._words) > 20:
            return
        lines = self._session.lines_since(self._heard)
        if lines:
            self._heard = lines[-1]["number"]
        self._words.append(json.dumps({**words, "lines": lines, **self._samples()}))
        self._wake.set()

    def plot(self) -> None:
        """Send samples of the variables that it watches."""
        samples = self._samples()
        if samples and len(self._words) < 20:
            self._words.append(json.dumps(samples))
            self._wake.set()

    def _samples(self) -> dict[str, Any]:
        chosen = self._session.watched.get(self)
        if not chosen:
            return {}
        times, rows = [], []
        for time, values in list(self._session.plotted):
            if time > self._plotted:
                times.append(round(time, 3))
                row = [values.get(key, math.nan) for key in chosen]
                rows.append([value if math.isfinite(value) else None for value in row])
        if not times:
            # time may have been turned back
            newest = self._session.plotted[-1][0] if self._session.plotted else -math.inf
            if newest < self._plotted - 0.2:
                self._plotted = -math.inf
            return {}
        self._plotted = times[-1]
        return {"plot": {"times": times, "rows": rows, "names": [f"{d}:{name}" for d, name in chosen]}}

    async def send(self) -> None:
        """Send what there is, until the browser has gone."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            frame, self._frame = self._frame, None
            words, self._words = self._words, []
            for text in words:
                await self._socket.send_text(text)
            if frame is not None:
                await self._socket.send_bytes(frame)

    async def listen(self) -> None:
        """Hear which variables it wants to plot: ``{"watch": [[drone, name], ...]}``. Anything else is ignored."""
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            text = message.get("text")
            if not isinstance(text, str) or len(text) > _MAX_WORDS:
                continue
            with contextlib.suppress(ValueError, RecursionError):
                self._take(json.loads(text))

    def _take(self, wish: Any) -> None:
        if not isinstance(wish, dict) or not isinstance(wish.get("watch"), list):
            return
        count, chosen = len(self._session.names), []
        for entry in wish["watch"][:_MAX_WATCHED]:
            is_pair = isinstance(entry, list) and len(entry) == 2 and isinstance(entry[1], str)
            if is_pair and type(entry[0]) is int and 0 <= entry[0] < count and len(entry[1]) <= 64:
                chosen.append((entry[0], entry[1]))
        self._session.watched[self] = tuple(chosen)
        self._plotted = -math.inf


PHASE_NAMES = PHASES
